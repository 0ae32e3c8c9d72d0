//! Changes of a travel in progress, as tables: see `talk` in `common/mod.rs`.

use crate::common::talk;

#[test]
fn a_travel_in_progress_gets_another_target() {
    talk(
        "@+5     E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=no-travel uncertain=0
         PO      Y
         G+400   Y
         @+5     E
         E       E
         PO      Y
         G+400   Y
         E       Y  -> start 1 50-1000 R200 R200 +400
         @+300   Y  -> change 1: @+300
         @-0     Y  -> change 1: @+0
         *refuse too-fast
         @+9     E
         A2      Y
         @+9     E
         A1      Y
         Z       Y  -> stop 1
         @-7     Y  -> change 1: @-7
         *arrive 1
         V1      -7
         @+1     E",
    );
}

#[test]
fn speed_and_ramps_change_on_the_way_and_for_later() {
    talk(
        "g+      Y  -> start 1 50-1000 R200 R200 forward
         t500    Y  -> change 1: t500
         a900    Y  -> change 1: a900
         d800    Y  -> change 1: d800
         *refuse too-fast
         t70000  E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=too-fast uncertain=0
         S5      E
         T70     E
         R9      E
         s0      E
         t0      E
         *arrive 1
         g-      Y  -> start 1 50-500 900/s2 800/s2 backward",
    );
}

#[test]
fn a_change_is_for_all_that_are_selected_or_for_none() {
    talk(
        "A0      Y
         g+      Y  -> start 1 50-1000 R200 R200 forward; start 2 50-1000 R200 R200 forward; start 3 50-1000 R200 R200 forward
         t300    Y  -> change 1 2 3: t300
         @+70    Y  -> change 1 2 3: @+70
         *arrive 2
         @+80    E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=no-travel uncertain=0
         *refuse ramp
         t310    E
         t320    Y  -> change 1 3: t320
         A2      Y
         g+      Y  -> start 2 50-320 R200 R200 forward
         t999999 Y  -> change 2: t999999",
    );
}

/// Lines of an order are for axes at rest: a stray line must not touch a motor.
#[test]
fn an_open_order_changes_nothing_on_the_way_but_by_name() {
    talk(
        "g+      Y  -> start 1 50-1000 R200 R200 forward
         A2      Y
         PO      Y
         A1      Y
         t20     E
         E       E
         @+5000  Y  -> change 1: @+5000",
    );
}

#[test]
fn settings_limit_a_travel_in_progress_too() {
    talk(
        "$max-speed=2000 Y  -> max-speed=2000
         $max-accel=9000 Y  -> max-accel=9000
         a9000   Y
         d9000   Y
         g+      Y  -> start 1 50-1000 9000/s2 9000/s2 forward
         t2001   E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=too-fast uncertain=0
         t2000   Y  -> change 1: t2000
         a9001   E
         d9001   E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=3 last=ramp uncertain=0
         d8000   Y  -> change 1: d8000",
    );
}
