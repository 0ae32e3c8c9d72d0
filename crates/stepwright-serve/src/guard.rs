//! Checks who may send requests at all, before a request is read.
//!
//! | check | reason |
//! | --- | --- |
//! | `Host` is an address, or `localhost` | a name of another site that points to this server must not pass |
//! | `Origin`, if present, is this server | a page of another site can open a WebSocket to this server |
//! | `Sec-Fetch-Site`, if present without `Origin`, is this server's page or nobody's | an image or a script of another site's page sends no `Origin` |
//! | the token, beyond loopback | everyone in the network can reach the port |

use std::net::IpAddr;
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::Uri;
use axum::http::header::{AUTHORIZATION, HOST, HeaderName, ORIGIN};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::secret::Token;
use stepwright_keeper::Declined;

/// The checks of requests.
#[derive(Debug)]
pub struct Guard {
    /// The token that all requests need; `None` on loopback.
    pub token: Option<Token>,
}

impl Guard {
    fn judge(&self, request: &Request) -> Result<(), Declined> {
        let header = |name: HeaderName| {
            request.headers().get(name).map(|value| value.to_str().unwrap_or("?"))
        };
        let host = header(HOST).unwrap_or_default();
        if !self.is_ours(host) {
            return Err(Declined::foreign(format!("'{host}' is no name of this server"))
                .allowed("an IP address, or localhost"));
        }
        if let Some(origin) = header(ORIGIN).filter(|origin| *origin != format!("http://{host}")) {
            return Err(Declined::foreign(format!("a page of {origin} may not ask this server"))
                .allowed("this server's own page, and programs"));
        }
        if !is_api(request) {
            return Ok(());
        }
        // An `Origin` says more: a browser may call a WebSocket of this page cross-site.
        let site = header(HeaderName::from_static("sec-fetch-site"));
        let site = site.filter(|_| header(ORIGIN).is_none());
        if site.is_some_and(|site| !["same-origin", "none"].contains(&site)) {
            return Err(Declined::foreign("a page of another site may not ask this server")
                .allowed("this server's own page, and programs"));
        }
        let Some(token) = &self.token else {
            return Ok(());
        };
        let bearer = header(AUTHORIZATION).and_then(|said| said.strip_prefix("Bearer "));
        // A browser can't add a header to a WebSocket.
        match bearer.or(in_query(request.uri(), "token")) {
            Some(said) if token.is(said) => Ok(()),
            Some(_) => Err(Declined::unknown("that is not the token").remedy(TOKEN)),
            None => Err(Declined::unknown("the token is missing").remedy(TOKEN)),
        }
    }

    /// Whether this is an address of this server. Beyond loopback the token protects it.
    fn is_ours(&self, host: &str) -> bool {
        let name = match host.rsplit_once(':') {
            Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
            _ => host,
        };
        let bare = name.strip_prefix('[').and_then(|name| name.strip_suffix(']'));
        match bare.unwrap_or(name).parse::<IpAddr>() {
            Ok(address) => self.token.is_some() || address.is_loopback(),
            Err(_) => name == "localhost",
        }
    }
}

const TOKEN: &str = "`stepwright serve` says it when it begins: send it in the header \
                     `Authorization: Bearer TOKEN`, or open the address that it says";

/// The value of a name after the `?` of an address.
pub(crate) fn in_query<'a>(uri: &'a Uri, name: &str) -> Option<&'a str> {
    let pairs = uri.query().unwrap_or_default().split('&').filter_map(|pair| pair.split_once('='));
    pairs.into_iter().find_map(|(one, value)| (one == name).then_some(value))
}

/// The page itself has no secrets, and another site may have a link to it.
fn is_api(request: &Request) -> bool {
    request.uri().path().starts_with("/api/")
}

/// Lets a request pass, or declines it.
pub(crate) async fn judge(
    State(guard): State<Arc<Guard>>,
    request: Request,
    next: Next,
) -> Response {
    match guard.judge(&request) {
        Ok(()) => next.run(request).await,
        Err(declined) => declined.into_response(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::body::Body;

    fn judged(guard: &Guard, path: &str, headers: &[(&str, &str)]) -> Result<(), u16> {
        let mut request = Request::builder().uri(path);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let request = request.body(Body::empty()).unwrap();
        guard.judge(&request).map_err(|declined| declined.status())
    }

    #[test]
    fn on_loopback_a_request_comes_from_this_machine_and_this_page() {
        let guard = Guard { token: None };
        let ask = |headers: &[(&str, &str)]| judged(&guard, "/api/state", headers);
        for host in ["localhost:8480", "127.0.0.1:8480", "[::1]:8480", "127.0.0.1", "localhost"] {
            assert_eq!(ask(&[("host", host)]), Ok(()), "{host}");
            let own = format!("http://{host}");
            assert_eq!(ask(&[("host", host), ("origin", &own)]), Ok(()), "{host}");
        }
        let no_hosts =
            ["", "evil.example", "evil.example:8480", "192.168.0.7:8480", "localhost.evil.example"];
        for host in no_hosts.into_iter().chain(["127.0.0.1.evil.example", "::1:x", "[::1"]) {
            assert_eq!(ask(&[("host", host)]), Err(403), "{host}");
        }
        assert_eq!(ask(&[]), Err(403));
        for origin in ["http://evil.example", "https://localhost:1", "http://localhost:2", "null"] {
            let headers = [("host", "localhost:1"), ("origin", origin)];
            assert_eq!(ask(&headers), Err(403), "{origin}");
        }
        for (site, right) in [
            ("same-origin", Ok(())),
            ("none", Ok(())),
            ("same-site", Err(403)),
            ("cross-site", Err(403)),
        ] {
            let headers = [("host", "localhost:1"), ("sec-fetch-site", site)];
            assert_eq!(judged(&guard, "/api/scope.mcap?seconds=10", &headers), right, "{site}");
            assert_eq!(judged(&guard, "/", &headers), Ok(()), "{site}");
            let own = [headers[0], headers[1], ("origin", "http://localhost:1")];
            assert_eq!(judged(&guard, "/api/live", &own), Ok(()), "{site}");
        }
    }

    #[test]
    fn beyond_loopback_the_token_is_needed_for_all_but_the_page() {
        let guard = Guard { token: Some(Token::new()) };
        let text = guard.token.as_ref().unwrap().text().to_owned();
        let host = ("host", "192.168.0.7:8480");
        let bearer = format!("Bearer {text}");
        assert_eq!(judged(&guard, "/", &[host]), Ok(()));
        assert_eq!(judged(&guard, "/api/state", &[host]), Err(401));
        assert_eq!(judged(&guard, "/api/state", &[host, ("authorization", &bearer)]), Ok(()));
        assert_eq!(judged(&guard, &format!("/api/live?a=b&token={text}"), &[host]), Ok(()));
        for wrong in ["", "0", &text[1..], &format!("{text}0")] {
            assert_eq!(judged(&guard, &format!("/api/live?token={wrong}"), &[host]), Err(401));
        }
        let name = ("host", "evil.example");
        assert_eq!(judged(&guard, "/api/state", &[name, ("authorization", &bearer)]), Err(403));
    }
}
