//! Files of lines, arcs and other moves of several motors, drawn: `/api/path`.
//!
//! What may stand in a file, and what a board makes of it, is the command's to say: it has a
//! reader for each kind of file, and gives a [`PathDrawing`], which knows no kind.

use std::sync::Arc;

use axum::extract::{DefaultBodyLimit, FromRequest, Request, State};
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::Body;
use crate::decline::Declined;
use crate::desk::ServeDesk;

/// A request with a file has a body of this many bytes at most.
pub const FILE: usize = 200_000;

/// Characters of a file's name, at most.
const NAME: usize = 100;

/// Who reads files and draws them.
pub trait PathReader: Send + Sync {
    /// Files to begin with.
    fn examples(&self) -> Vec<PathFile>;

    /// What the motors do by this file. Takes seconds at most; nothing moves.
    ///
    /// # Errors
    /// What is wrong with the file, or too long to be drawn.
    fn draw(&self, file: &PathFile) -> Result<PathDrawing, Declined>;
}

/// A file: `POST /api/path`, and `GET /api/path/examples`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PathFile {
    /// What messages call it.
    #[schema(example = "square.toml", max_length = 100)]
    pub name: String,
    /// Its text: motor cycles, as `stepwright cycle` reads them.
    #[schema(example = "[[motor]]\nname = \"X\"\nstep = 10\nsmallest-delay-us = 100\n\
        [[cycle]]\nline = { to = { X = 500 }, speed = 1000, accel = 5000 }\n")]
    pub text: String,
}

/// What the motors do by a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct PathDrawing {
    /// What positions are counted in; speeds are in it a second.
    pub unit: String,
    /// The motors.
    pub motors: Vec<PathMotor>,
    /// How long all of it takes, in s.
    pub seconds: f64,
    /// The highest speed along the path.
    pub peak: f64,
    /// Its parts, in the order of time.
    pub legs: Vec<PathLeg>,
    /// When the points below are, in s from the beginning.
    pub times: Vec<f64>,
    /// The speed along the path then.
    pub speeds: Vec<f64>,
    /// Where each motor is then.
    pub places: Vec<Vec<f64>>,
}

/// A motor of a file.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PathMotor {
    /// Its name in the file.
    pub name: String,
    /// How far a step leads.
    pub step: f64,
}

/// A part of a drawing.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PathLeg {
    /// `line`, `arc`, `home`, `moves` of motors each by itself, or `rest`.
    pub kind: &'static str,
    /// The line of the file in which it stands.
    pub line: usize,
    /// When it begins, in s from the beginning.
    pub begin: f64,
    /// When it ends.
    pub end: f64,
    /// Its highest speed along the path.
    pub peak: f64,
    /// The speed that was ordered, of a line or an arc.
    pub ordered: Option<f64>,
    /// Its first point.
    pub first: usize,
    /// Its last point.
    pub last: usize,
}

type Shared = State<Arc<ServeDesk>>;

/// Its addresses.
pub(crate) fn routes() -> Router<Arc<ServeDesk>> {
    Router::new()
        .route("/api/path", post(draw).layer(DefaultBodyLimit::max(FILE)))
        .route("/api/path/examples", get(examples))
}

impl PathFile {
    /// The file of a request.
    async fn of(request: Request) -> Result<PathFile, Declined> {
        let Body(file) = Body::<PathFile>::from_request(request, &()).await.map_err(
            |declined| match declined.status() {
                413 => declined.allowed(format!("at most {FILE} bytes")),
                _ => declined,
            },
        )?;
        if file.name.chars().count() > NAME || file.name.chars().any(char::is_control) {
            return Err(Declined::range("name is none of a file")
                .allowed(format!("at most {NAME} characters, none of them control characters")));
        }
        Ok(file)
    }
}

/// The paths of this server.
pub(crate) fn reader(desk: &ServeDesk) -> Result<Arc<dyn PathReader>, Declined> {
    desk.paths().ok_or_else(|| Declined::nowhere("there is nobody who reads paths"))
}

/// Files to begin with.
#[utoipa::path(get, path = "/api/path/examples", operation_id = "path_examples",
    responses((status = 200, body = Vec<PathFile>), (status = "4XX", body = Declined)))]
pub(crate) async fn examples(State(desk): Shared) -> Result<Json<Vec<PathFile>>, Declined> {
    Ok(Json(reader(&desk)?.examples()))
}

/// What the motors would do by a file: points with their times and speeds. Nothing moves.
#[utoipa::path(post, path = "/api/path", operation_id = "path_draw", request_body = PathFile,
    responses((status = 200, body = PathDrawing), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
pub(crate) async fn draw(
    State(desk): Shared,
    request: Request,
) -> Result<Json<PathDrawing>, Declined> {
    let file = PathFile::of(request).await?;
    let reader = reader(&desk)?;
    // One drawing after another: each keeps a processor busy.
    let _turn = desk.drawing.lock().await;
    let drawn = tokio::task::spawn_blocking(move || reader.draw(&file)).await;
    drawn.unwrap_or_else(|_| Err(Declined::away("the drawing broke off"))).map(Json)
}
