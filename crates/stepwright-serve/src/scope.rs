//! The pins of the last seconds: `/api/scope`.

use std::sync::Arc;

use axum::Router;
use axum::extract::{DefaultBodyLimit, FromRequest, RawQuery, Request, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};

use stepwright_keeper::Declined;
use stepwright_keeper::request::outside;
use stepwright_keeper::scope::{LONGEST, ScopeFile, ScopeRecord, csv, mcap, vcd};

use crate::api::Body;
use crate::desk::ServeDesk;

/// The most bytes of a request with a record: 10 s of several fast axes.
pub const RECORD: usize = 8_000_000;

type Shared = State<Arc<ServeDesk>>;

/// The addresses of the scope.
pub(crate) fn routes() -> Router<Arc<ServeDesk>> {
    Router::new()
        .route("/api/scope", get(scope))
        .route("/api/scope.vcd", get(as_vcd))
        .route("/api/scope.csv", get(as_csv))
        .route("/api/scope.mcap", get(as_mcap))
        .route("/api/scope/file", post(as_file).layer(DefaultBodyLimit::max(RECORD)))
}

/// Reads `seconds=2` of a query; 2 without it.
fn asked(desk: &ServeDesk, query: Option<&str>) -> Result<ScopeRecord, Declined> {
    let mut seconds = 2.0;
    for pair in query.unwrap_or_default().split('&').filter(|pair| !pair.is_empty()) {
        match pair.split_once('=') {
            // The guard has read the token.
            Some(("token", _)) => {}
            Some(("seconds", said)) => {
                let right = said.parse().ok().filter(|s| (0.001..=LONGEST).contains(s));
                let wrong = || outside(said, "seconds", 0.001, LONGEST, "s");
                seconds = right.ok_or_else(wrong)?;
            }
            _ => {
                return Err(Declined::range(format!("'{pair}' is nothing that can be asked"))
                    .allowed("seconds=2"));
            }
        }
    }
    desk.scope(seconds)
}

/// Makes something of a record on a thread of its own: others are answered meanwhile. One after another, as each
/// keeps a processor busy.
async fn made<T: Send + 'static>(
    desk: Arc<ServeDesk>,
    make: impl FnOnce(&ServeDesk) -> Result<T, Declined> + Send + 'static,
) -> Result<T, Declined> {
    let turn = desk.making.clone().lock_owned().await;
    let made = tokio::task::spawn_blocking(move || {
        let _turn = turn;
        make(&desk)
    });
    made.await.unwrap_or_else(|_| Err(Declined::away("the record broke off")))
}

fn file(kind: &'static str, name: &str, content: impl Into<axum::body::Body>) -> Response {
    let name = format!("attachment; filename=\"{name}\"");
    let content = content.into();
    ([(CONTENT_TYPE, kind.to_owned()), (CONTENT_DISPOSITION, name)], content).into_response()
}

/// STEP and DIR, or coils, and enable of the last seconds.
#[utoipa::path(get, path = "/api/scope",
    params(("seconds" = Option<f64>, Query, description = "how many: 0.001 to 10 [default: 2]",
        minimum = 0.001, maximum = 10)),
    responses((status = 200, body = ScopeRecord), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
pub(crate) async fn scope(
    State(desk): Shared,
    RawQuery(query): RawQuery,
) -> Result<Response, Declined> {
    let record = made(desk, move |desk| {
        let record = asked(desk, query.as_deref())?;
        serde_json::to_vec(&record).map_err(|error| Declined::refused(format!("no JSON: {error}")))
    });
    Ok(([(CONTENT_TYPE, "application/json")], record.await?).into_response())
}

/// The same as a Value Change Dump.
#[utoipa::path(get, path = "/api/scope.vcd",
    params(("seconds" = Option<f64>, Query, description = "as of /api/scope",
        minimum = 0.001, maximum = 10)),
    responses((status = 200, body = String, content_type = "text/plain"), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
pub(crate) async fn as_vcd(
    State(desk): Shared,
    RawQuery(query): RawQuery,
) -> Result<Response, Declined> {
    let made = made(desk, move |desk| asked(desk, query.as_deref()).map(|record| vcd(&record)));
    Ok(file("text/plain", "stepwright.vcd", made.await?))
}

/// The same as a table: µs, and every level.
#[utoipa::path(get, path = "/api/scope.csv",
    params(("seconds" = Option<f64>, Query, description = "as of /api/scope",
        minimum = 0.001, maximum = 10)),
    responses((status = 200, body = String, content_type = "text/csv"), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
pub(crate) async fn as_csv(
    State(desk): Shared,
    RawQuery(query): RawQuery,
) -> Result<Response, Declined> {
    let made = made(desk, move |desk| asked(desk, query.as_deref()).map(|record| csv(&record)));
    Ok(file("text/csv", "stepwright.csv", made.await?))
}

/// The same as an MCAP file, for Foxglove and PlotJuggler: a channel for each pin, and a channel with position
/// and speed for each axis with STEP and DIR.
#[utoipa::path(get, path = "/api/scope.mcap",
    params(("seconds" = Option<f64>, Query, description = "as of /api/scope",
        minimum = 0.001, maximum = 10)),
    responses((status = 200, body = Vec<u8>, content_type = "application/octet-stream"), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
pub(crate) async fn as_mcap(
    State(desk): Shared,
    RawQuery(query): RawQuery,
) -> Result<Response, Declined> {
    let made = made(desk, move |desk| {
        let record = asked(desk, query.as_deref())?;
        mcap(&record).map_err(|error| Declined::refused(format!("no MCAP: {error}")))
    });
    Ok(file("application/octet-stream", "stepwright.mcap", made.await?))
}

/// The file of a record from `GET /api/scope`: a page saves what it shows.
#[utoipa::path(post, path = "/api/scope/file", operation_id = "scope_file", request_body = ScopeRecord,
    params(("ending" = String, Query, description = "of its name: vcd, csv or mcap")),
    responses((status = 200, body = Vec<u8>, content_type = "application/octet-stream"), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
pub(crate) async fn as_file(
    State(desk): Shared,
    RawQuery(query): RawQuery,
    request: Request,
) -> Result<Response, Declined> {
    let query = query.unwrap_or_default();
    // The query may also have a token, which the guard has read.
    let said = query.split('&').find_map(|pair| pair.strip_prefix("ending=")).unwrap_or_default();
    let form = ScopeFile::named(said)
        .ok_or_else(|| Declined::range(format!("ending is '{said}'")).allowed("vcd, csv, mcap"))?;
    let Body(record) =
        Body::<ScopeRecord>::from_request(request, &()).await.map_err(|declined| match declined
            .status()
        {
            413 => declined.allowed(format!("at most {RECORD} bytes")),
            _ => declined,
        })?;
    let made = made(desk, move |_| {
        form.of(&record).map_err(|error| Declined::refused(format!("no file: {error}")))
    });
    Ok(file("application/octet-stream", &format!("stepwright.{said}"), made.await?))
}
