//! Files of lines, arcs and other moves of several motors, drawn and run: `/api/path`.
//!
//! What may stand in a file, and what a board makes of it, is the command's to say: it has a
//! reader for each kind of file, and gives a [`PathDrawing`], which knows no kind.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use axum::extract::{DefaultBodyLimit, FromRequest, Request, State};
use axum::http::HeaderMap;
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::{Body, hand};
use crate::desk::ServeDesk;
use stepwright_keeper::Declined;
use stepwright_keeper::report::{Done, PathReport};

/// A request with a file has a body of this many bytes at most.
pub const FILE: usize = 200_000;

/// Characters of a file's name, at most.
const NAME: usize = 100;

/// Who reads files, draws and runs them.
pub trait PathReader: Send + Sync {
    /// Files to begin with, and where files are run.
    fn table(&self) -> PathTable;

    /// What the motors do by this file. Takes seconds at most; nothing moves.
    ///
    /// # Errors
    /// What is wrong with the file, or too long to be drawn.
    fn draw(&self, file: &PathFile) -> Result<PathDrawing, Declined>;

    /// Begins to run a file that was drawn so, and tells how that goes on.
    ///
    /// # Errors
    /// Another file is being run, or this one can't be.
    fn run(
        &self,
        file: &PathFile,
        drawing: &PathDrawing,
        tell: PathListener,
    ) -> Result<(), Declined>;

    /// Has the run that there is stop. Does not wait.
    fn stop(&self);

    /// Has the run that there is end dead. Does not wait.
    fn kill(&self);
}

/// What is told how a run goes on.
pub type PathListener = Box<dyn Fn(PathReport) + Send>;

/// Files to begin with, and where files are run: `GET /api/path/examples`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct PathTable {
    /// The port of the board on which files are run; none: a virtual board.
    pub port: Option<String>,
    /// What that board is called.
    pub board: String,
    /// The same for people, and what a stop does there.
    pub player: String,
    /// The files.
    pub examples: Vec<PathFile>,
}

/// A file: `POST /api/path`, and of `GET /api/path/examples`.
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
    /// The same for the same text: that of a [`PathReport`].
    pub id: String,
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
    /// `line`, `arc`, `path` of several of them, `home`, `moves` of motors each by itself, or `rest`.
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
        .route("/api/path", get(report).post(draw).layer(DefaultBodyLimit::max(FILE)))
        .route("/api/path/run", post(run).layer(DefaultBodyLimit::max(FILE)))
        .route("/api/path/examples", get(examples))
}

impl PathFile {
    /// The same for the same text, and hardly for another.
    pub fn id(&self) -> String {
        let mut hasher = DefaultHasher::new();
        self.text.hash(&mut hasher);
        format!("{:016x}", hasher.finish())
    }

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

/// Files to begin with, and where files are run.
#[utoipa::path(get, path = "/api/path/examples", operation_id = "path_examples",
    responses((status = 200, body = PathTable), (status = "4XX", body = Declined)))]
pub(crate) async fn examples(State(desk): Shared) -> Result<Json<PathTable>, Declined> {
    Ok(Json(reader(&desk)?.table()))
}

/// What the motors would do by a file: points with their times and speeds. Nothing moves.
#[utoipa::path(post, path = "/api/path", operation_id = "path_draw", request_body = PathFile,
    responses((status = 200, body = PathDrawing), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
pub(crate) async fn draw(
    State(desk): Shared,
    request: Request,
) -> Result<Json<PathDrawing>, Declined> {
    let file = PathFile::of(request).await?;
    drawn(&desk, &file).await.map(Json)
}

async fn drawn(desk: &ServeDesk, file: &PathFile) -> Result<PathDrawing, Declined> {
    let (reader, file) = (reader(desk)?, file.clone());
    // One drawing after another: each keeps a processor busy.
    let _turn = desk.drawing.lock().await;
    let drawn = tokio::task::spawn_blocking(move || reader.draw(&file)).await;
    drawn.unwrap_or_else(|_| Err(Declined::away("the drawing broke off")))
}

/// How the last run goes on, or has ended; null if there was none.
#[utoipa::path(get, path = "/api/path", operation_id = "path_report",
    responses((status = 200, body = Option<PathReport>), (status = "4XX", body = Declined)))]
pub(crate) async fn report(State(desk): Shared) -> Json<Option<PathReport>> {
    Json(desk.path_report())
}

/// Run a file: it is drawn first, so that only one that has an end is begun. Answered when it
/// has begun; `GET /api/path` and `/api/live` say how it goes on. A stop of all axes stops it.
#[utoipa::path(post, path = "/api/path/run", operation_id = "path_run", request_body = PathFile,
    params(("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
pub(crate) async fn run(
    State(desk): Shared,
    headers: HeaderMap,
    request: Request,
) -> Result<Json<Done>, Declined> {
    let file = PathFile::of(request).await?;
    hand(&desk, &headers)?;
    let drawing = drawn(&desk, &file).await?;
    // Another one may have taken control meanwhile.
    hand(&desk, &headers)?;
    let listener = desk.clone();
    let tell = Box::new(move |report| listener.follow_path(report));
    reader(&desk)?.run(&file, &drawing, tell)?;
    Ok(Json(Done::default()))
}
