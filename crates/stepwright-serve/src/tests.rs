//! Requests to the server without a board: the answers, and that declined requests never reach the board's
//! thread.

use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Method, Request, StatusCode, header};
use serde_json::{Value, json};
use tower::ServiceExt;

use crate::path::{PathDrawing, PathFile, PathListener, PathReader, PathTable};
use crate::{DeskEnd, Guard, ServeDesk, Token};
use stepwright_keeper::Declined;
use stepwright_keeper::report::Done;
use stepwright_keeper::scope::{ScopeRecord, ScopeSource};
use stepwright_keeper::{Hand, KeeperDesk, Wish};

/// A server, with a board's thread that notes the wishes.
struct Bench {
    router: Router,
    desk: Arc<ServeDesk>,
    wishes: Arc<Mutex<Vec<Wish>>>,
}

impl Bench {
    fn new(guard: Guard) -> Bench {
        let (desk, wishes) = (Arc::new(ServeDesk::default()), Arc::new(Mutex::default()));
        let bench = Bench { router: crate::router(desk.clone(), guard), desk, wishes };
        let (desk, wishes) = (bench.desk.clone(), bench.wishes.clone());
        std::thread::spawn(move || {
            // Until only this thread holds the desk.
            while Arc::strong_count(&desk) > 1 {
                if let Some(job) = desk.next(Duration::from_millis(20)) {
                    wishes.lock().unwrap().push(job.wish.clone());
                    job.answer(Ok(Done::default()));
                }
            }
        });
        bench
    }

    async fn send(&self, request: Request<Body>) -> (StatusCode, Value) {
        let answer = self.router.clone().oneshot(request).await.unwrap();
        let status = answer.status();
        let body = to_bytes(answer.into_body(), 1 << 20).await.unwrap();
        (status, serde_json::from_slice(&body).unwrap_or(Value::Null))
    }

    async fn post(&self, path: &str, key: Option<&str>, body: &str) -> (StatusCode, Value) {
        let mut request = Request::post(path)
            .header(header::HOST, "localhost:8480")
            .header(header::CONTENT_TYPE, "application/json");
        if let Some(key) = key {
            request = request.header("Stepwright-Control", key);
        }
        self.send(request.body(Body::from(body.to_owned())).unwrap()).await
    }

    async fn key(&self) -> String {
        let (status, given) = self.post("/api/control", None, "{}").await;
        assert_eq!(status, StatusCode::OK);
        given["key"].as_str().unwrap().to_owned()
    }

    fn wishes(&self) -> Vec<Wish> {
        self.wishes.lock().unwrap().clone()
    }
}

fn open() -> Bench {
    Bench::new(Guard { token: None })
}

/// All addresses that move or change something, with valid bodies.
const ORDERS: [(&str, &str); 10] = [
    ("/api/move", r#"{"axis":1,"by":4000}"#),
    ("/api/line", r#"{"by":[2000,-500]}"#),
    ("/api/run", r#"{"axis":1,"speed":-400}"#),
    ("/api/home", r#"{"axis":1,"slow":20}"#),
    ("/api/retarget", r#"{"axis":1,"to":10}"#),
    ("/api/zero", r#"{"axis":1}"#),
    ("/api/set", r#"{"name":"idle-ms","value":5}"#),
    ("/api/acknowledge", "{}"),
    ("/api/stop", "{}"),
    ("/api/kill", "{}"),
];

#[tokio::test]
async fn orders_reach_the_board() {
    let bench = open();
    let key = bench.key().await;
    for (path, body) in ORDERS {
        let (status, said) = bench.post(path, Some(&key), body).await;
        assert_eq!(status, StatusCode::OK, "{path}: {said}");
    }
    assert_eq!(bench.wishes().len(), ORDERS.len());
}

#[tokio::test]
async fn without_control_only_a_stop_and_a_kill_reach_it() {
    let bench = open();
    for other in [false, true] {
        if other {
            bench.key().await;
        }
        for (path, body) in ORDERS {
            for key in [None, Some(""), Some("0123456789abcdef0123456789abcdef")] {
                let (status, said) = bench.post(path, key, body).await;
                let urgent = ["/api/stop", "/api/kill"].contains(&path);
                let right = if urgent { StatusCode::OK } else { StatusCode::CONFLICT };
                assert_eq!(status, right, "{path}: {said}");
                assert!(urgent || said["do"].is_string(), "{said}");
            }
        }
    }
    assert!(bench.wishes().iter().all(Wish::is_urgent));
}

#[tokio::test]
async fn nonsense_is_declined_with_the_reason_and_the_remedy() {
    let bench = open();
    let key = bench.key().await;
    let bodies =
        ["", "{", "[]", "[null]", "null", "4000", "\"G+4000\"", "{\"axis\":1,\"axis\":1}", "\u{0}"];
    let more = [
        "[1]",
        "[1,4000]",
        r#"{"axis":1}x"#,
        r#"{"unknown":1}"#,
        r#"{"axis":1e99,"by":1}"#,
        "{}{}",
    ];
    for (path, _) in ORDERS {
        for body in bodies.iter().chain(&more) {
            let (status, said) = bench.post(path, Some(&key), body).await;
            assert!(status.is_client_error(), "{path} {body:?}: {status} {said}");
            assert!(said["what"].is_string() && said["do"].is_string(), "{path} {body:?}: {said}");
        }
        let long = format!("{{\"axis\":1,\"by\":1{}}}", " ".repeat(crate::BODY));
        let (status, said) = bench.post(path, Some(&key), &long).await;
        assert_eq!(status, StatusCode::PAYLOAD_TOO_LARGE, "{path}");
        assert_eq!(said["what"], "the body is too long", "{path}");
        assert_eq!(said["allowed"], "at most 4096 bytes");
    }
    for (body, what) in [
        (
            r#"{"axis":300,"by":1}"#,
            "axis: invalid value: integer `300`, expected the number of an axis at line 1 column 11",
        ),
        (
            r#"{"axis":1,"by":1.5}"#,
            "by: invalid type: floating point `1.5`, expected a whole number at line 1 column 18",
        ),
        (
            r#"{"axis":1,"by":1,"accel":[]}"#,
            "accel: invalid type: a list, expected a number at line 1 column 25",
        ),
        (
            r#"{"axis":1,"by":{}}"#,
            "by: invalid type: an object, expected a whole number at line 1 column 15",
        ),
        (r#"{"by":1}"#, "missing field `axis` at line 1 column 8"),
        (r#"{"axis":1"#, "no JSON: EOF while parsing an object at line 1 column 9"),
    ] {
        let (_, said) = bench.post("/api/move", Some(&key), body).await;
        assert_eq!(said["what"], what, "{body}");
    }
    let (_, said) = bench.post("/api/line", Some(&key), r#"{"by":3}"#).await;
    assert_eq!(said["what"], "by: invalid type: integer `3`, expected a list at line 1 column 7");
    for name in ["", "a\\nb", &"n".repeat(101)] {
        let body = format!(r#"{{"name":"{name}","text":""}}"#);
        let (status, said) = bench.post("/api/path", Some(&key), &body).await;
        assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY, "{name}");
        assert_eq!(said["what"], "name is none of a file", "{name}");
    }
    let (status, said) =
        bench.post("/api/move", Some(&key), r#"{"axis":1,"by":1,"accel":0.5}"#).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY);
    assert_eq!(said, json!({"what": "accel is 0.5", "allowed": "1 to 100000000 steps/s²"}));
    let huge = r#"{"axis":1,"by":1,"accel":1e300}"#;
    let (_, said) = bench.post("/api/move", Some(&key), huge).await;
    assert_eq!(said["what"], "accel is 100000000000000000000000…");
    assert_eq!(bench.wishes(), []);
}

#[tokio::test]
async fn a_form_of_another_page_is_no_order() {
    let bench = open();
    let key = bench.key().await;
    for kind in ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data"] {
        for (path, body) in ORDERS {
            let request = Request::post(path)
                .header(header::HOST, "localhost")
                .header("Stepwright-Control", &key)
                .header(header::CONTENT_TYPE, kind);
            let (status, _) = bench.send(request.body(Body::from(body)).unwrap()).await;
            assert_eq!(status, StatusCode::UNSUPPORTED_MEDIA_TYPE, "{path}");
        }
    }
    assert_eq!(bench.wishes(), []);
}

#[tokio::test]
async fn who_may_not_ask_reaches_nothing() {
    let token = Token::new();
    let bench = Bench::new(Guard { token: Some(token.clone()) });
    let ask = async |host: &str, origin: Option<&str>, token: Option<&str>| {
        for (path, body) in ORDERS {
            let mut request = Request::post(path)
                .header(header::HOST, host)
                .header(header::CONTENT_TYPE, "application/json");
            if let Some(origin) = origin {
                request = request.header(header::ORIGIN, origin);
            }
            if let Some(token) = token {
                request = request.header(header::AUTHORIZATION, format!("Bearer {token}"));
            }
            let (status, said) = bench.send(request.body(Body::from(body)).unwrap()).await;
            let closed = [StatusCode::UNAUTHORIZED, StatusCode::FORBIDDEN].contains(&status);
            assert!(closed, "{path}: {status} {said}");
        }
    };
    ask("192.168.0.7:8480", None, None).await;
    ask("192.168.0.7:8480", None, Some("0")).await;
    ask("192.168.0.7:8480", Some("http://evil.example"), Some(token.text())).await;
    ask("evil.example", None, Some(token.text())).await;
    let request = Request::get("/api/live").header(header::HOST, "192.168.0.7:8480");
    let (status, _) = bench.send(request.body(Body::empty()).unwrap()).await;
    assert_eq!(status, StatusCode::UNAUTHORIZED);
    assert_eq!(bench.wishes(), []);
}

#[tokio::test]
async fn what_is_told_says_so_and_stays_on_this_page() {
    let bench = open();
    let pages = ["/", "/style.css", "/main.js", "/api/state", "/api/board", "/api/openapi.json"];
    let told = pages.map(|path| (path, "localhost", StatusCode::OK));
    let declined = [
        ("/nowhere", "localhost", StatusCode::NOT_FOUND),
        ("/api/move", "localhost", StatusCode::METHOD_NOT_ALLOWED),
        ("/", "evil.example", StatusCode::FORBIDDEN),
    ];
    for (path, host, status) in told.into_iter().chain(declined) {
        let request = Request::get(path).header(header::HOST, host);
        let answer = bench.router.clone().oneshot(request.body(Body::empty()).unwrap()).await;
        let answer = answer.unwrap();
        assert_eq!(answer.status(), status, "{path}");
        let policy = answer.headers()[header::CONTENT_SECURITY_POLICY].to_str().unwrap();
        assert!(policy.starts_with("default-src 'none'"), "{policy}");
        assert!(policy.contains("frame-ancestors 'none'"), "{policy}");
    }
    for (method, path, right) in [
        (Method::GET, "/nowhere", StatusCode::NOT_FOUND),
        (Method::GET, "/api/move", StatusCode::METHOD_NOT_ALLOWED),
        (Method::PUT, "/api/stop", StatusCode::METHOD_NOT_ALLOWED),
        (Method::POST, "/api/scope", StatusCode::METHOD_NOT_ALLOWED),
    ] {
        let request = Request::builder().method(method).uri(path).header(header::HOST, "localhost");
        let (status, said) = bench.send(request.body(Body::empty()).unwrap()).await;
        assert_eq!(status, right, "{path}");
        assert!(said["what"].is_string(), "{said}");
    }
}

#[test]
fn the_description_has_every_address_and_what_it_takes() {
    let api: Value = serde_json::from_str(&crate::api::openapi()).unwrap();
    let described: Vec<_> = api["paths"].as_object().unwrap().keys().cloned().collect();
    for (path, _) in ORDERS {
        assert!(described.iter().any(|one| one == path), "{path}");
        let body = &api["paths"][path]["post"]["requestBody"]["content"]["application/json"];
        let name = body["schema"]["$ref"].as_str().unwrap().rsplit('/').next().unwrap();
        let schema = &api["components"]["schemas"][name];
        assert_eq!(schema["additionalProperties"], false, "{path}: {schema}");
    }
    for read in ["/api/board", "/api/state", "/api/control", "/api/control/beat"] {
        assert!(described.iter().any(|one| one == read), "{read}");
    }
}

#[tokio::test]
async fn who_hangs_up_while_waiting_is_there_no_longer() {
    let desk = Arc::new(ServeDesk::default());
    let router = crate::router(desk.clone(), Guard { token: None });
    let ask = |path: &str, key: &str, body: &str| {
        let request = Request::post(path)
            .header(header::HOST, "localhost")
            .header(header::CONTENT_TYPE, "application/json")
            .header("Stepwright-Control", key);
        router.clone().oneshot(request.body(Body::from(body.to_owned())).unwrap())
    };
    let given = ask("/api/control", "", "{}").await.unwrap();
    let given = to_bytes(given.into_body(), 1 << 20).await.unwrap();
    let given: Value = serde_json::from_slice(&given).unwrap();
    let (key, hand) = (given["key"].as_str().unwrap(), Hand(given["hand"].as_u64().unwrap()));
    let waits = ask("/api/home?wait=true", key, r#"{"axis":1,"within":900}"#);
    let begun = tokio::time::timeout(crate::control::LEASE, waits).await;
    // The request is not answered, and is given up after a lease.
    assert!(begun.is_err());
    let job = desk.next(Duration::ZERO).unwrap();
    assert!(job.waits && desk.is_live(hand), "the lease begins when nobody waits any more");
    job.answer(Ok(Done::default()));
    // While a request waits, others are answered, including a stop.
    let next = async || loop {
        match desk.next(Duration::ZERO) {
            Some(job) => break job,
            None => tokio::task::yield_now().await,
        }
    };
    let long = tokio::spawn(ask("/api/move?wait=true", key, r#"{"axis":1,"by":9}"#));
    let waits = next().await;
    tokio::time::sleep(crate::control::LEASE).await;
    assert!(desk.is_there(hand) && !desk.is_live(hand));
    let taken = ask("/api/control", "", "{}").await.unwrap();
    assert_eq!(taken.status(), StatusCode::CONFLICT);
    let stop = tokio::spawn(ask("/api/stop", "", "{}"));
    let urgent = next().await;
    assert!(urgent.wish.is_urgent());
    urgent.answer(Ok(Done::default()));
    assert_eq!(stop.await.unwrap().unwrap().status(), StatusCode::OK);
    waits.answer(Ok(Done::default()));
    assert_eq!(long.await.unwrap().unwrap().status(), StatusCode::OK);
}

#[tokio::test]
async fn a_run_has_no_end_to_wait_for() {
    let bench = open();
    let key = bench.key().await;
    let body = r#"{"axis":1,"speed":-400}"#;
    let (status, said) = bench.post("/api/run?wait=true", Some(&key), body).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY, "{said}");
    assert!(said["allowed"].as_str().unwrap().contains("wait=true of a move"), "{said}");
    assert_eq!(bench.wishes(), []);
}

/// A source of edges that waits until it is released.
struct SlowPins(Mutex<mpsc::Receiver<()>>);

impl ScopeSource for SlowPins {
    fn record(&self, _: f64, _: f64) -> ScopeRecord {
        self.0.lock().unwrap().recv_timeout(Duration::from_secs(20)).expect("it is not released");
        ScopeRecord::default()
    }
}

#[tokio::test]
async fn a_stop_waits_for_no_record() {
    for form in ["", ".vcd", ".csv", ".mcap"] {
        let (bench, (release, held)) = (open(), mpsc::channel());
        bench.desk.probe(Arc::new(SlowPins(Mutex::new(held))));
        let request =
            Request::get(format!("/api/scope{form}")).header(header::HOST, "localhost:8480");
        let request = request.body(Body::empty()).unwrap();
        let record = tokio::spawn(bench.router.clone().oneshot(request));
        tokio::time::sleep(Duration::from_millis(20)).await;
        assert_eq!(bench.post("/api/stop", None, "{}").await.0, StatusCode::OK);
        release.send(()).unwrap();
        assert_eq!(record.await.unwrap().unwrap().status(), StatusCode::OK, "{form}");
    }
}

/// A reader that counts how many draw at once, and at most.
#[derive(Default)]
struct Drawers(Mutex<(u32, u32)>);

impl PathReader for Drawers {
    fn table(&self) -> PathTable {
        unreachable!()
    }

    fn draw(&self, _: &PathFile) -> Result<PathDrawing, Declined> {
        let count = |by: i32| {
            let mut now = self.0.lock().unwrap();
            now.0 = now.0.strict_add_signed(by);
            now.1 = now.1.max(now.0);
        };
        count(1);
        std::thread::sleep(Duration::from_millis(100));
        count(-1);
        Ok(PathDrawing::default())
    }

    fn run(&self, _: &PathFile, _: &PathDrawing, _: PathListener) -> Result<(), Declined> {
        Ok(())
    }

    fn stop(&self) {}

    fn hold(&self, _: bool) -> Result<(), Declined> {
        Ok(())
    }

    fn kill(&self) {}
}

#[tokio::test]
async fn drawings_that_nobody_waits_for_do_not_pile_up() {
    let (bench, drawers) = (open(), Arc::new(Drawers::default()));
    bench.desk.read_paths_by(drawers.clone());
    for n in 0..3 {
        let body = format!(r#"{{"name":"a","text":"{n}"}}"#);
        let asked = bench.post("/api/path", None, &body);
        // The client hangs up.
        assert!(tokio::time::timeout(Duration::from_millis(30), asked).await.is_err());
    }
    let (status, _) = bench.post("/api/path", None, r#"{"name":"a","text":"last"}"#).await;
    assert_eq!((status, *drawers.0.lock().unwrap()), (StatusCode::OK, (0, 1)));
}

#[tokio::test]
async fn a_panic_of_the_boards_thread_ends_the_server() {
    let desk = Arc::new(ServeDesk::default());
    let order = desk.wish(Wish::Kill, false);
    let board = std::thread::spawn({
        let end = DeskEnd(desk.clone());
        move || {
            let _end = end;
            panic!("as it should")
        }
    });
    assert!(board.join().is_err());
    let patience = Duration::from_secs(20);
    assert!(tokio::time::timeout(patience, order).await.unwrap().is_err());
    tokio::time::timeout(patience, desk.until_ended()).await.unwrap();
}
