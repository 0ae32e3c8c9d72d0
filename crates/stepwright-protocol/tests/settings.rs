//! The settings of a board, over the line, as tables: see `talk` in `common/mod.rs`.

use crate::common::talk;
use stepwright_protocol::Setting;

#[test]
fn settings_are_asked_and_set() {
    talk(
        "$pulse-us     pulse-us=2
         $pulse-us=15  Y  -> pulse-us=15
         $pulse-us=15  Y
         $pulse-us     pulse-us=15
         $idle-ms=0060000 Y -> idle-ms=60000
         $             max-speed=1000000 max-accel=100000000 idle-ms=60000 ahead-x=0 ahead-y=0 ahead-z=0 behind-x=0 behind-y=0 behind-z=0 timeout-ms=0 enable-ms=1 setup-us=1 hold-us=1 pulse-us=15 reverse=0 enable-high=0 switches=0 switch-forward=0 switch-high=0 debounce-ms=25 law=1 safe-start=0 home-first=0 estop=0 driver-fault=0 kill-off=0 soft-limits=0
         $reset        Y  -> idle-ms=0; pulse-us=2
         $reset        Y
         $idle-ms      idle-ms=0",
    );
}

#[test]
fn a_setting_is_refused_with_its_reason() {
    talk(
        "$pulse-us=21  E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=range uncertain=0
         $pulse=2      E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=2 last=setting uncertain=0
         $pulse-us=    E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=3 last=line uncertain=0
         A2      Y
         g+      Y  -> start 2 50-1000 R200 R200 forward
         A1      Y
         $pulse-us=3   E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=4 last=busy uncertain=0
         $reset        E
         $pulse-us     pulse-us=2
         *arrive 2
         $pulse-us=3   Y  -> pulse-us=3",
    );
}

/// A refused setting spoils an order, an accepted one does not, as with any other line.
#[test]
fn settings_may_stand_inside_an_order() {
    talk(
        "PO      Y
         G+5     Y
         $hold-us=2    Y  -> hold-us=2
         $hold-us      hold-us=2
         E       Y  -> start 1 50-1000 R200 R200 +5
         *arrive 1
         PO      Y
         G+5     Y
         $hold-us=-1   E
         E       E",
    );
}

/// The text below the table in `docs/settings.md`.
const BELOW: &str = "
Values for sets of axes are sums: 1 for X, 2 for Y, 4 for Z.

On the serial line `$` lists the settings, `$idle-ms` returns one, `$idle-ms=60000` sets it, and
`$reset` restores the defaults. The board refuses to change settings while a motor moves.

An Uno, a Nano and a Mega keep their settings without power. Any other board keeps them only over
a reset, and has the defaults after each power-up: [safety.md](safety.md#stored-settings).

A closed switch stops its axis at once. The position is that of the last step. A motor
that was faster than its start speed may have slipped some steps beyond: approach a switch slowly,
or zero the axis afterwards. The board then refuses orders towards the switch (`fault`), but takes orders
away from it.

A motor whose driver is switched off holds no load: leave `idle-ms` at 0 where a load could turn
the motor.

[safety.md](safety.md) describes the inputs, the limits and the locks in detail.
";

/// `docs/settings.md`, made from the table.
fn page() -> String {
    let mut page = String::from(
        "# Settings\n\nThis table lists all settings of a board in the order of the answer to `$`. \
         `stepwright settings set --help`\nprints the same texts.\n\n\
         | setting | range | default | what it does |\n|---|---|---|---|\n",
    );
    for setting in Setting::ALL {
        let (name, unit, help) = (setting.name(), setting.unit(), setting.help());
        let (least, most) = setting.range().into_inner();
        let range = format!("{least} to {most} {unit}");
        let range = range.trim_end();
        page += &format!("| `{name}` | {range} | {} | {help} |\n", setting.default());
    }
    page + BELOW
}

#[test]
fn the_page_of_settings_is_the_table() {
    let place = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/settings.md");
    if std::env::var("STEPWRIGHT_GOLDEN").is_ok_and(|golden| golden == "write") {
        std::fs::write(place, page()).unwrap();
    }
    let text = std::fs::read_to_string(place).unwrap();
    assert_eq!(text, page(), "STEPWRIGHT_GOLDEN=write cargo test writes it");
}
