//! The calculators of the command, for pages and programs: `/api/calc`.
//!
//! What they take, and what comes of it, is the command's to say: here is only the way there.

use std::sync::Arc;

use axum::extract::State;
use axum::routing::get;
use axum::{Json, Router};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::Body;
use crate::desk::ServeDesk;
use stepwright_keeper::Declined;

/// The calculators, and how one is asked.
pub struct Calculators {
    /// What there is.
    pub sheets: Vec<CalculatorSheet>,
    /// Computes, by the words behind `stepwright calc`.
    pub answer: fn(&[String]) -> Result<CalcAnswer, Declined>,
}

/// A calculator.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct CalculatorSheet {
    /// Its name: `belt`.
    pub name: String,
    /// What it is for.
    pub about: String,
    /// What it takes.
    pub options: Vec<CalcOption>,
}

/// A thing that a calculator takes.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct CalcOption {
    /// As it is typed: `--teeth`; of a value that stands alone, its name: `SPEED`.
    pub name: String,
    /// Whether the value stands alone.
    pub bare: bool,
    /// Whether it takes a value.
    pub takes_value: bool,
    /// What it means.
    pub help: String,
    /// What holds if it is left out.
    pub default: Option<String>,
    /// Whether it must be given.
    pub required: bool,
    /// What it may be, where that is a list.
    pub choices: Vec<String>,
}

/// `POST /api/calc`: the words behind `stepwright calc`.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CalcRequest {
    /// The calculator, and what it takes.
    #[schema(example = json!(["belt", "--teeth", "20"]))]
    words: Vec<String>,
}

/// What a calculator has found out.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct CalcAnswer {
    /// The heading.
    pub title: String,
    /// Single results.
    pub facts: Vec<CalcFact>,
    /// The heads of the table.
    pub columns: Vec<String>,
    /// As many cells each.
    pub rows: Vec<Vec<String>>,
    /// What one should know besides.
    pub notes: Vec<String>,
}

/// A single result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct CalcFact {
    /// What it is.
    pub name: String,
    /// How much.
    pub value: String,
    /// Of what.
    pub unit: String,
}

type Shared = State<Arc<ServeDesk>>;

/// Its addresses.
pub(crate) fn routes() -> Router<Arc<ServeDesk>> {
    Router::new().route("/api/calc", get(list).post(answer))
}

/// The calculators that there are.
#[utoipa::path(get, path = "/api/calc", operation_id = "calculators",
    responses((status = 200, body = Vec<CalculatorSheet>), (status = "4XX", body = Declined)))]
pub(crate) async fn list(State(desk): Shared) -> Json<Vec<CalculatorSheet>> {
    Json(desk.calculators().map_or_else(Vec::new, |all| all.sheets.clone()))
}

/// Calculate: timers, delays, belts, drivers. Nothing moves.
#[utoipa::path(post, path = "/api/calc", operation_id = "calculate", request_body = CalcRequest,
    responses((status = 200, body = CalcAnswer), (status = "4XX", body = Declined)))]
pub(crate) async fn answer(
    State(desk): Shared,
    Body(body): Body<CalcRequest>,
) -> Result<Json<CalcAnswer>, Declined> {
    let all = desk.calculators().ok_or_else(|| Declined::nowhere("there are no calculators"))?;
    (all.answer)(&body.words).map(Json)
}
