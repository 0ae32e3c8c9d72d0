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
pub const FILE: usize = 4_000_000;

/// Characters of a file's name, at most.
const NAME: usize = 100;

/// S of a laser's full power, from here to there.
const LASER: [f64; 2] = [0.001, 1e6];

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

    /// Has the run that there is brake and stand, or go on. Does not wait.
    ///
    /// # Errors
    /// There is none, or it is none that can be held.
    fn hold(&self, held: bool) -> Result<(), Declined>;

    /// Has the run that there is end dead. Does not wait.
    fn kill(&self);
}

/// What is told how a run goes on.
pub type PathListener = Box<dyn Fn(PathReport) + Send>;

/// Files to begin with, and where files are run: `GET /api/path/examples`.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PathTable {
    /// The port of the board on which files are run; none: a virtual board.
    pub port: Option<String>,
    /// What that board is called.
    pub board: String,
    /// The same for people, and what a stop does there.
    pub player: String,
    /// The three of G-code jobs: the port,
    pub job_port: Option<String>,
    /// what that board is called,
    pub job_board: String,
    /// and the same for people.
    pub jobs: String,
    /// How the names of G-code jobs end: `.nc`.
    pub job_endings: Vec<String>,
    /// The longest request with a file, in bytes.
    pub longest: usize,
    /// The files.
    pub examples: Vec<PathFile>,
}

/// A file: `POST /api/path`, and of `GET /api/path/examples`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PathFile {
    /// What messages call it.
    #[schema(example = "square.toml", min_length = 1, max_length = 100)]
    pub name: String,
    /// Its text: G-code, as `stepwright gcode` reads it, if the name ends as that of a job does;
    /// otherwise motor cycles, as `stepwright cycle` reads them.
    #[schema(example = "[[motor]]\nname = \"X\"\nstep = 10\nsmallest-delay-us = 100\n\
        [[cycle]]\nline = { to = { X = 500 }, speed = 1000, accel = 5000 }\n")]
    pub text: String,
    /// Of a job, S of full power of a laser, as grbl's `$30`: M3, M4 and S are its power along the path.
    /// Without it they are a spindle's, which rests for each.
    #[schema(minimum = 0.001, maximum = 1000000)]
    pub laser: Option<f64>,
}

/// What the motors do by a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct PathDrawing {
    /// The same for the same text and laser: that of a [`PathReport`].
    pub id: String,
    /// `cycles`, or `gcode`.
    pub kind: &'static str,
    /// What positions are counted in; speeds are in it a second.
    pub unit: String,
    /// The motors.
    pub motors: Vec<PathMotor>,
    /// How long all of it takes, in s.
    pub seconds: f64,
    /// The highest speed along the path.
    pub peak: f64,
    /// What else is known of it, in words: of a job its exact time, its extents, the corners that
    /// cost most.
    pub facts: Vec<PathFact>,
    /// Why the board would refuse to run it, if it would.
    pub refused: Option<String>,
    /// Its parts, in the order of time.
    pub legs: Vec<PathLeg>,
    /// When the points below are, in s from the beginning.
    pub times: Vec<f64>,
    /// The speed along the path then.
    pub speeds: Vec<f64>,
    /// Of a job with a laser its power then, from 0, off, to 1. Where it jumps there are two points of
    /// one time.
    pub powers: Option<Vec<f64>>,
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

/// What is known of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct PathFact {
    /// What it is; of a corner its place, in mm.
    pub name: String,
    /// How much; of a corner what it costs, and how fast it is passed.
    pub value: String,
    /// The line of a corner.
    pub line: Option<usize>,
}

/// A part of a drawing.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PathLeg {
    /// `line`, `arc`, `path` of several of them, `home`, `moves` of motors each by itself, or `rest`;
    /// of a job also `rapid`, `probe`, and `lines` for several lines of a long one.
    pub kind: &'static str,
    /// The line of the file in which it stands.
    pub line: usize,
    /// The last line of several; otherwise the same.
    pub to_line: usize,
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
        .route("/api/path/hold", post(hold))
        .route("/api/path/resume", post(resume))
        .route("/api/path/examples", get(examples))
}

impl PathFile {
    /// The same for the same text and laser, and hardly for another.
    pub fn id(&self) -> String {
        let mut hasher = DefaultHasher::new();
        self.text.hash(&mut hasher);
        self.laser.map(f64::to_bits).hash(&mut hasher);
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
        let length = file.name.chars().count();
        if !(1..=NAME).contains(&length) || file.name.chars().any(char::is_control) {
            return Err(Declined::range("name is none of a file")
                .allowed(format!("1 to {NAME} characters, none of them control characters")));
        }
        let [least, most] = LASER;
        if file.laser.is_some_and(|s| !(least..=most).contains(&s)) {
            return Err(Declined::range("laser is no S of full power")
                .allowed(format!("{least} to {most}")));
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
    let mut last = desk.drawing.lock().await;
    if let Some((_, drawing)) = last.as_ref().filter(|(known, _)| *known == file) {
        return Ok(drawing.clone());
    }
    let drawn = tokio::task::spawn_blocking(move || {
        let drawing = reader.draw(&file)?;
        Ok((file, drawing))
    });
    let drawn = drawn.await.unwrap_or_else(|_| Err(Declined::away("the drawing broke off")))?;
    Ok(last.insert(drawn).1.clone())
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
    let stops = desk.stops();
    let drawing = drawn(&desk, &file).await?;
    // Another one may have taken control meanwhile.
    hand(&desk, &headers)?;
    let stopped = || match desk.stops() == stops {
        true => Ok(()),
        false => Err(Declined::refused("it was stopped before it had begun")),
    };
    stopped()?;
    let listener = desk.clone();
    let tell = Box::new(move |report| listener.follow_path(report));
    let reader = reader(&desk)?;
    reader.run(&file, &drawing, tell)?;
    // A stop that came just before found nothing to stop.
    stopped().inspect_err(|_| reader.stop())?;
    Ok(Json(Done::default()))
}

/// Have the run of a G-code job brake along its path, and stand there until it is resumed.
#[utoipa::path(post, path = "/api/path/hold", operation_id = "path_hold",
    params(("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined)))]
pub(crate) async fn hold(State(desk): Shared, headers: HeaderMap) -> Result<Json<Done>, Declined> {
    hand(&desk, &headers)?;
    reader(&desk)?.hold(true).map(|()| Json(Done::default()))
}

/// Have a run that is held go on.
#[utoipa::path(post, path = "/api/path/resume", operation_id = "path_resume",
    params(("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined)))]
pub(crate) async fn resume(
    State(desk): Shared,
    headers: HeaderMap,
) -> Result<Json<Done>, Declined> {
    hand(&desk, &headers)?;
    reader(&desk)?.hold(false).map(|()| Json(Done::default()))
}
