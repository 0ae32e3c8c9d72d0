mod common;
use common::*;
#[test]
fn dbg() {
    let mut chip = chip();
    say(&mut chip, "PO s0 t20000 a40000 d40000 G+20000 E");
    assert!(chip.run_to_silence(8_000_000, 16_000_000 * 30));
    let path = path_of_accel(0, 20_000, 40_000, 20_000);
    let r = steps(&chip, 0);
    let off = |n: usize| (r[n].time - r[0].time) as i64 - path.time_of(n as u32) as i64;
    for n in (0..20).chain(r.len() - 40..r.len()) { println!("{n} {} off {} interval {}", r[n].time, off(n), if n > 0 { r[n].time - r[n-1].time } else { 0 }); }
    for n in 1..r.len() { if (off(n) - off(n-1)).abs() > 60 { println!("jump at {n}: {} -> {}", off(n-1), off(n)); } }
    println!("{:?}", chip.ask("?"));
}
