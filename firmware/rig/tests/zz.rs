mod common;
use common::*;
fn go(order: &str, traffic: bool) {
    let mut chip = chip();
    say(&mut chip, order);
    if traffic { for k in 0..30 { let t = std::time::Instant::now(); let a = chip.ask(if k % 2 == 0 { "V1" } else { "F" }); let _ = (t, a); } }
    assert!(chip.run_to_silence(8_000_000, 16_000_000 * 60));
    let r = steps(&chip, 0);
    let mut prev = 0i64; let mut n_j = 0;
    for n in 2..r.len() { let d = (r[n].time - r[n-1].time) as i64; let d0 = (r[n-1].time - r[n-2].time) as i64; if (d - d0).abs() > 40 && n > 40 && n + 40 < r.len() { n_j += 1; if n_j < 25 { println!("{n} interval {d0} -> {d} at {}", r[n].time); } } prev = d; }
    let _ = prev;
    println!("{order}: {} steps, {n_j} jumps, {:?}", r.len(), chip.ask("?"));
}
#[test]
fn dbg() {
    go("PO s0 t60000 a40000 d40000 G+100000 E", false);
    go("PO s60000 t60000 a40000 d40000 G+100000 E", false);
    go("PO s0 t20000 a40000 d40000 G+20000 E", true);
}
