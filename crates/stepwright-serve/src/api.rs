//! The requests over HTTP, and their description.
//!
//! Every order except a stop and a kill needs control: the key from `POST /api/control`, in the header
//! `Stepwright-Control`.

use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

use axum::extract::{FromRequest, Request, State};
use axum::http::HeaderMap;
use axum::http::header::CONTENT_TYPE;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Extension, Json, Router};
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use tokio::time::timeout;
use utoipa::OpenApi;

use crate::control::LEASE;
use crate::crowd::{PATIENCE, Place, Standing};
use crate::desk::ServeDesk;
use crate::wait::Wait;
use crate::{calc, live, path, scope};
use stepwright_keeper::Declined;
use stepwright_keeper::Hand;
use stepwright_keeper::report::{BoardSheet, ControlGiven, Done, LiveMessage, LiveState};
use stepwright_keeper::request::home::HomeRequest;
use stepwright_keeper::request::line::LineRequest;
use stepwright_keeper::request::{
    ControlRequest, EmptyRequest, MoveRequest, RetargetRequest, RunRequest, SetRequest,
    StopRequest, Wish, ZeroRequest,
};

/// The header with the controlling client's key.
const CONTROL: &str = "stepwright-control";

type Shared = State<Arc<ServeDesk>>;
type Answer = Result<Json<Done>, Declined>;

#[derive(OpenApi)]
#[openapi(
    info(
        title = "stepwright serve",
        description = "Drive a stepper board: JSON over HTTP, and one WebSocket at /api/live \
                       that tells what the board does. Lengths are steps, times seconds."
    ),
    paths(
        board,
        state,
        travel,
        line,
        run,
        home,
        retarget,
        stop,
        kill,
        zero,
        set,
        acknowledge,
        take,
        beat,
        release,
        calc::list,
        calc::answer,
        scope::scope,
        scope::as_vcd,
        scope::as_csv,
        scope::as_mcap,
        scope::as_file,
        path::draw,
        path::examples,
        path::report,
        path::run,
        path::hold,
        path::resume
    ),
    components(schemas(LiveMessage))
)]
struct Description;

/// All addresses under `/api`.
pub(crate) fn routes() -> Router<Arc<ServeDesk>> {
    Router::new()
        .route("/api/board", get(board))
        .route("/api/state", get(state))
        .route("/api/move", post(travel))
        .route("/api/line", post(line))
        .route("/api/run", post(run))
        .route("/api/home", post(home))
        .route("/api/retarget", post(retarget))
        .route("/api/stop", post(stop))
        .route("/api/kill", post(kill))
        .route("/api/zero", post(zero))
        .route("/api/set", post(set))
        .route("/api/acknowledge", post(acknowledge))
        .route("/api/control", post(take))
        .route("/api/control/beat", post(beat))
        .route("/api/control/release", post(release))
        .route("/api/live", get(live::join))
        .route("/api/openapi.json", get(description))
        .merge(calc::routes())
        .merge(scope::routes())
        .merge(path::routes())
        .method_not_allowed_fallback(async || {
            Declined::otherwise("this address takes another method")
                .remedy("GET /api/openapi.json lists them")
        })
}

/// The description of the API in OpenAPI.
pub(crate) fn openapi() -> String {
    Description::openapi().to_json().unwrap_or_default()
}

async fn description() -> impl IntoResponse {
    ([(CONTENT_TYPE, "application/json")], openapi())
}

/// A request's body, deserialized.
pub(crate) struct Body<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for Body<T> {
    type Rejection = Declined;

    async fn from_request(request: Request, state: &S) -> Result<Body<T>, Declined> {
        let read = timeout(PATIENCE, Json::from_request(request, state)).await;
        let Json(Object(body)) = read.map_err(|_| Declined::slow(PATIENCE))??;
        Ok(Body(body))
    }
}

/// A JSON object. An array, whose fields go by their places, is refused.
struct Object<T>(T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Object<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Object<T>, D::Error> {
        from.deserialize_map(Fields(PhantomData)).map(Object)
    }
}

struct Fields<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Fields<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, fields: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(fields))
    }
}

/// The key in a request's headers.
fn key(headers: &HeaderMap) -> Option<&str> {
    headers.get(CONTROL).and_then(|value| value.to_str().ok())
}

/// The hand of an order. It must have control.
pub(crate) fn hand(desk: &ServeDesk, headers: &HeaderMap) -> Result<Hand, Declined> {
    desk.control(|control, now| control.hear(key(headers), now))
}

/// Raises the standing of the controlling client's connection.
pub(crate) async fn known(
    State(desk): Shared,
    place: Option<Extension<Arc<Place>>>,
    request: Request,
    next: Next,
) -> Response {
    let controls = |key| desk.control(|control, _| control.is_key(key));
    if let Some(Extension(place)) = place
        && key(request.headers()).is_some_and(controls)
    {
        place.stand(Standing::Controlling);
    }
    next.run(request).await
}

async fn wish(desk: &ServeDesk, wish: Wish) -> Answer {
    desk.wish(wish, false).await.map(Json)
}

/// The board's description and its settings.
#[utoipa::path(get, path = "/api/board", responses((status = 200, body = BoardSheet)))]
async fn board(State(desk): Shared) -> Json<BoardSheet> {
    Json(desk.sheet())
}

/// The present state of the board.
#[utoipa::path(get, path = "/api/state", responses((status = 200, body = LiveState)))]
async fn state(State(desk): Shared) -> Json<LiveState> {
    Json(desk.state())
}

/// Travel by a distance, or to a position. Answered when the motor has started, or with `?wait=true` when it
/// rests. A client that hangs up before leaves the motion as it is.
#[utoipa::path(post, path = "/api/move", request_body = MoveRequest,
    params(("wait" = Option<bool>, Query, description = "answer when the order has ended, and how"),
        ("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
async fn travel(
    State(desk): Shared,
    headers: HeaderMap,
    wait: Wait,
    Body(body): Body<MoveRequest>,
) -> Answer {
    let asked = body.wish()?;
    let hand = hand(&desk, &headers)?;
    wait.wish(&desk, hand, asked).await
}

/// Move several axes together along a straight line, by distances or to positions. Answered like a move.
#[utoipa::path(post, path = "/api/line", request_body = LineRequest,
    params(("wait" = Option<bool>, Query, description = "answer when the order has ended, and how"),
        ("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
async fn line(
    State(desk): Shared,
    headers: HeaderMap,
    wait: Wait,
    Body(body): Body<LineRequest>,
) -> Answer {
    let asked = body.wish()?;
    let hand = hand(&desk, &headers)?;
    wait.wish(&desk, hand, asked).await
}

/// Run until a stop, or until the controlling client is silent for longer than the lease.
#[utoipa::path(post, path = "/api/run", request_body = RunRequest,
    params(("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
async fn run(
    State(desk): Shared,
    headers: HeaderMap,
    wait: Wait,
    Body(body): Body<RunRequest>,
) -> Answer {
    wait.not()?;
    let hand = hand(&desk, &headers)?;
    wish(&desk, body.wish(hand)?).await
}

/// Find 0 by the limit switch of an axis. Answered when the motor has started, and the state then shows the
/// progress; or with `?wait=true` when it rests. The client must be heard from until the homing is done, or
/// wait for the answer.
#[utoipa::path(post, path = "/api/home", request_body = HomeRequest,
    params(("wait" = Option<bool>, Query, description = "answer when the order has ended, and how"),
        ("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
async fn home(
    State(desk): Shared,
    headers: HeaderMap,
    wait: Wait,
    Body(body): Body<HomeRequest>,
) -> Answer {
    let hand = hand(&desk, &headers)?;
    wait.wish(&desk, hand, body.wish(hand)?).await
}

/// Change the present travel of an axis: its target, its speed, its ramps.
#[utoipa::path(post, path = "/api/retarget", request_body = RetargetRequest,
    params(("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
async fn retarget(
    State(desk): Shared,
    headers: HeaderMap,
    Body(body): Body<RetargetRequest>,
) -> Answer {
    let asked = body.wish()?;
    hand(&desk, &headers)?;
    wish(&desk, asked).await
}

/// Brake one axis, or all; the position is kept. Needs no control.
#[utoipa::path(post, path = "/api/stop", request_body = StopRequest,
    responses((status = 200, body = Done), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
async fn stop(State(desk): Shared, Body(body): Body<StopRequest>) -> Answer {
    wish(&desk, body.wish()?).await
}

/// Stop every axis at once; the position of an axis that moves is lost. Needs no control.
#[utoipa::path(post, path = "/api/kill", request_body = EmptyRequest,
    responses((status = 200, body = Done), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
async fn kill(State(desk): Shared, Body(_): Body<EmptyRequest>) -> Answer {
    wish(&desk, Wish::Kill).await
}

/// Make the present position of an axis 0.
#[utoipa::path(post, path = "/api/zero", request_body = ZeroRequest,
    params(("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
async fn zero(State(desk): Shared, headers: HeaderMap, Body(body): Body<ZeroRequest>) -> Answer {
    let asked = body.wish()?;
    hand(&desk, &headers)?;
    wish(&desk, asked).await
}

/// Change a setting of the board. An Uno, a Nano and a Mega keep it without power.
#[utoipa::path(post, path = "/api/set", request_body = SetRequest,
    params(("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
async fn set(State(desk): Shared, headers: HeaderMap, Body(body): Body<SetRequest>) -> Answer {
    let asked = body.wish()?;
    hand(&desk, &headers)?;
    wish(&desk, asked).await
}

/// Make the board forget its errors.
#[utoipa::path(post, path = "/api/acknowledge", request_body = EmptyRequest,
    params(("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined), (status = 503, body = Declined)))]
async fn acknowledge(
    State(desk): Shared,
    headers: HeaderMap,
    Body(_): Body<EmptyRequest>,
) -> Answer {
    hand(&desk, &headers)?;
    wish(&desk, Wish::Acknowledge).await
}

/// Take control.
#[utoipa::path(post, path = "/api/control", request_body = ControlRequest,
    responses((status = 200, body = ControlGiven), (status = "4XX", body = Declined)))]
async fn take(
    State(desk): Shared,
    Body(body): Body<ControlRequest>,
) -> Result<Json<ControlGiven>, Declined> {
    let grant = desk.control(|control, now| control.take(&body.name, body.take_over, now))?;
    let lease_ms = LEASE.as_millis() as u32;
    Ok(Json(ControlGiven { hand: grant.hand.0, key: grant.key, lease_ms }))
}

/// Renew the lease.
#[utoipa::path(post, path = "/api/control/beat", request_body = EmptyRequest,
    params(("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined)))]
async fn beat(State(desk): Shared, headers: HeaderMap, Body(_): Body<EmptyRequest>) -> Answer {
    hand(&desk, &headers)?;
    Ok(Json(Done::default()))
}

/// Give control back.
#[utoipa::path(post, path = "/api/control/release", request_body = EmptyRequest,
    params(("Stepwright-Control" = String, Header, description = "the key of who controls")),
    responses((status = 200, body = Done), (status = "4XX", body = Declined)))]
async fn release(State(desk): Shared, headers: HeaderMap, Body(_): Body<EmptyRequest>) -> Answer {
    desk.control(|control, now| control.release(key(&headers), now))?;
    Ok(Json(Done::default()))
}
