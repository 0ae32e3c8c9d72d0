//! The calculators of the command, for pages and programs: `/api/calc`.
//!
//! The command defines what the calculators take and return; this module only passes it on.

use std::sync::Arc;

use axum::extract::State;
use axum::routing::get;
use axum::{Json, Router};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::Body;
use crate::desk::ServeDesk;
use stepwright_keeper::Declined;

/// The calculators, and how to ask them.
pub struct Calculators {
    /// The descriptions of the calculators.
    pub sheets: Vec<CalculatorSheet>,
    /// Computes, from the words after `stepwright calc`.
    pub answer: fn(&[String]) -> Result<CalcAnswer, Declined>,
}

/// A calculator.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct CalculatorSheet {
    /// Its name: `belt`.
    pub name: String,
    /// Its purpose.
    pub about: String,
    /// Its options.
    pub options: Vec<CalcOption>,
}

/// An option of a calculator.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct CalcOption {
    /// The option as it is typed: `--teeth`; the name of a value without an option: `SPEED`.
    pub name: String,
    /// Whether the value has no option.
    pub bare: bool,
    /// Whether it takes a value.
    pub takes_value: bool,
    /// Its meaning.
    pub help: String,
    /// The value if it is left out.
    pub default: Option<String>,
    /// Whether it must be given.
    pub required: bool,
    /// The possible values, if there is a list of them.
    pub choices: Vec<String>,
}

/// `POST /api/calc`: the words after `stepwright calc`.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CalcRequest {
    /// The calculator and its options.
    #[schema(example = json!(["belt", "--teeth", "20"]))]
    words: Vec<String>,
}

/// The answer of a calculator.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct CalcAnswer {
    /// The heading.
    pub title: String,
    /// Single results.
    pub facts: Vec<CalcFact>,
    /// The headings of the table.
    pub columns: Vec<String>,
    /// The rows, with one cell for each column.
    pub rows: Vec<Vec<String>>,
    /// Notes.
    pub notes: Vec<String>,
}

/// A single result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct CalcFact {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: String,
    /// Its unit.
    pub unit: String,
}

type Shared = State<Arc<ServeDesk>>;

/// The addresses of the calculators.
pub(crate) fn routes() -> Router<Arc<ServeDesk>> {
    Router::new().route("/api/calc", get(list).post(answer))
}

/// The list of calculators.
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
