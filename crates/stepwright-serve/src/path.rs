//! Files of lines, arcs and other moves of several motors, drawn and run: `/api/path`.
//!
//! The command defines the contents of a file and how a board plays them. It has a reader for each kind of
//! file, which returns a [`PathDrawing`] that is the same for all kinds.

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
pub use stepwright_keeper::drawing::{PathDrawing, PathFact, PathLeg, PathMotor};
use stepwright_keeper::report::{Done, PathReport};

/// The most bytes of a request with a file.
pub const FILE: usize = 4_000_000;

/// The most characters of a file's name.
const NAME: usize = 100;

/// The range of S for a laser's full power.
const LASER: [f64; 2] = [0.001, 1e6];

/// Reads, draws and runs files.
pub trait PathReader: Send + Sync {
    /// Example files, and the board on which files are run.
    fn table(&self) -> PathTable;

    /// What the motors do with this file. Takes seconds at most; nothing moves.
    ///
    /// # Errors
    /// An error in the file, or a file that is too long to draw.
    fn draw(&self, file: &PathFile) -> Result<PathDrawing, Declined>;

    /// Begins to run a file with this drawing, and reports the progress to `tell`.
    ///
    /// # Errors
    /// Another file is being run, or this one can't be.
    fn run(
        &self,
        file: &PathFile,
        drawing: &PathDrawing,
        tell: PathListener,
    ) -> Result<(), Declined>;

    /// Stops the present run. Does not wait.
    fn stop(&self);

    /// Brakes the present run and holds it, or resumes it. Does not wait.
    ///
    /// # Errors
    /// There is no run, or it can't be held.
    fn hold(&self, held: bool) -> Result<(), Declined>;

    /// Kills the present run. Does not wait.
    fn kill(&self);
}

/// Receives the progress of a run.
pub type PathListener = Box<dyn Fn(PathReport) + Send>;

/// Example files, and the board on which files are run: `GET /api/path/examples`.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PathTable {
    /// The port of the board on which files are run; none for a virtual board.
    pub port: Option<String>,
    /// The name of that board.
    pub board: String,
    /// The board in words, and what a stop does there.
    pub player: String,
    /// The same for G-code jobs: the port,
    pub job_port: Option<String>,
    /// the name of the board,
    pub job_board: String,
    /// and the board in words.
    pub jobs: String,
    /// The endings of the names of G-code jobs: `.nc`.
    pub job_endings: Vec<String>,
    /// The most bytes of a request with a file.
    pub longest: usize,
    /// The example files.
    pub examples: Vec<PathFile>,
}

/// A file: in `POST /api/path` and `GET /api/path/examples`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PathFile {
    /// Its name in messages.
    #[schema(example = "square.toml", min_length = 1, max_length = 100)]
    pub name: String,
    /// Its text: G-code, as `stepwright gcode` reads it, if the name has the ending of a job; otherwise motor
    /// cycles, as `stepwright cycle` reads them.
    #[schema(example = "[[motor]]\nname = \"X\"\nstep = 10\nsmallest-delay-us = 100\n\
        [[cycle]]\nline = { to = { X = 500 }, speed = 1000, accel = 5000 }\n")]
    pub text: String,
    /// For a job, the S of a laser's full power, as grbl's `$30`: M3, M4 and S then set the laser's power along
    /// the path. Without it they control a spindle, and the path rests at each of them.
    #[schema(minimum = 0.001, maximum = 1000000)]
    pub laser: Option<f64>,
}

type Shared = State<Arc<ServeDesk>>;

/// The addresses of paths.
pub(crate) fn routes() -> Router<Arc<ServeDesk>> {
    Router::new()
        .route("/api/path", get(report).post(draw).layer(DefaultBodyLimit::max(FILE)))
        .route("/api/path/run", post(run).layer(DefaultBodyLimit::max(FILE)))
        .route("/api/path/hold", post(hold))
        .route("/api/path/resume", post(resume))
        .route("/api/path/examples", get(examples))
}

impl PathFile {
    /// An identifier of the text and the laser; other files hardly have the same.
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

/// The server's reader of paths.
pub(crate) fn reader(desk: &ServeDesk) -> Result<Arc<dyn PathReader>, Declined> {
    desk.paths().ok_or_else(|| Declined::nowhere("there is nobody who reads paths"))
}

/// Example files, and the board on which files are run.
#[utoipa::path(get, path = "/api/path/examples", operation_id = "path_examples",
    responses((status = 200, body = PathTable), (status = "4XX", body = Declined)))]
pub(crate) async fn examples(State(desk): Shared) -> Result<Json<PathTable>, Declined> {
    Ok(Json(reader(&desk)?.table()))
}

/// What the motors would do with a file: points with their times and speeds. Nothing moves.
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
    // One drawing after another: each keeps a processor busy, also when nobody waits for it any more.
    let mut last = desk.drawing.clone().lock_owned().await;
    if let Some((_, drawing)) = last.as_ref().filter(|(known, _)| known == file) {
        return Ok(drawing.clone());
    }
    let (reader, file) = (reader(desk)?, file.clone());
    let drawn = tokio::task::spawn_blocking(move || {
        let drawing = reader.draw(&file)?;
        Ok(last.insert((file, drawing)).1.clone())
    });
    drawn.await.unwrap_or_else(|_| Err(Declined::away("the drawing broke off")))
}

/// The progress of the last run, or how it ended; null if there was none.
#[utoipa::path(get, path = "/api/path", operation_id = "path_report",
    responses((status = 200, body = Option<PathReport>), (status = "4XX", body = Declined)))]
pub(crate) async fn report(State(desk): Shared) -> Json<Option<PathReport>> {
    Json(desk.path_report())
}

/// Run a file. It is drawn first, so that only a file with an end is begun. Answered when the run has begun;
/// `GET /api/path` and `/api/live` report the progress. A stop of all axes stops it.
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
    // Another client may have taken control meanwhile.
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

/// Brake the run of a G-code job along its path, and hold it until it is resumed.
#[utoipa::path(post, path = "/api/path/hold", operation_id = "path_hold",
    params(("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined)))]
pub(crate) async fn hold(State(desk): Shared, headers: HeaderMap) -> Result<Json<Done>, Declined> {
    hand(&desk, &headers)?;
    reader(&desk)?.hold(true).map(|()| Json(Done::default()))
}

/// Resume a run that is held.
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
