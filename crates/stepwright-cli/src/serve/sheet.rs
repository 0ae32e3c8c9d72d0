//! What the board is, for pages.

use stepwright_protocol::{Ability, Command, Info, Listed, Reply, Setting};
use stepwright_serve::report::{AxisSheet, BoardSheet, SettingSheet};

use stepwright_host::{LinkError, Session};

/// Asks the board what it is.
pub fn of(
    session: &mut Session,
    (unit, steps_per_unit): (&'static str, f64),
) -> Result<BoardSheet, LinkError> {
    let info = session.info().copied();
    // A board that has no settings refuses to list them, which is no trouble.
    let listed = match info.map(|_| session.once(Command::Settings)).transpose()?.flatten() {
        Some(Reply::Settings(listed)) => Some(listed),
        _ => None,
    };
    let has_switch = |axis: u8| {
        let switches = listed.as_ref().and_then(|listed| listed.get(Setting::Switches));
        switches.is_some_and(|axes| axes.number() >> (axis - 1) & 1 != 0)
    };
    let axes = 1..=info.map_or(1, |info| info.axes);
    Ok(BoardSheet {
        name: session.name(),
        protocol: info.map(|info| format!("{}.{}", info.version.0, info.version.1)),
        can: info.and_then(abilities).unwrap_or_default(),
        max_speed: info.map(|info| info.max),
        axes: axes
            .map(|axis| AxisSheet {
                axis,
                unit,
                steps_per_unit,
                switch: has_switch(axis),
                home_within: None,
            })
            .collect(),
        settings: listed.as_ref().map_or_else(Vec::new, settings),
        machine: None,
    })
}

fn abilities(info: Info) -> Option<Vec<&'static str>> {
    let can = info.can?;
    Some(Ability::ALL.into_iter().filter(|one| can.has(*one)).map(Ability::name).collect())
}

fn settings(listed: &Listed) -> Vec<SettingSheet> {
    let row = |value: stepwright_protocol::Value| {
        let setting = value.setting();
        let (min, max) = setting.range().into_inner();
        SettingSheet {
            name: setting.name(),
            value: value.number(),
            default: setting.default(),
            min,
            max,
            unit: setting.unit(),
            help: setting.help(),
        }
    };
    listed.values().map(row).collect()
}
