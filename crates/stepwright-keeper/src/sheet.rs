//! The board's description, for pages.

use stepwright_host::{Conversation, LinkError};
use stepwright_protocol::{Ability, AxisId, Command, Info, Listed, Reply, Setting};

use crate::keeper::KeptBoard;
use crate::report::{AxisSheet, BoardSheet, SettingSheet};

/// Asks the board for its description.
pub async fn of(talk: &mut Conversation, board: &KeptBoard) -> Result<BoardSheet, LinkError> {
    let info = talk.info().copied();
    // A board without settings refuses to list them, which is no error.
    let listed = match info {
        Some(_) => match talk.ask(Command::Settings).await? {
            Reply::Settings(listed) => Some(listed),
            _ => None,
        },
        None => None,
    };
    let switches = listed.as_ref().and_then(|listed| listed.get(Setting::Switches));
    let switches = switches.map_or(0, |axes| axes.number());
    let axis = |id: AxisId| {
        let own = board.units.iter().find(|(one, _)| *one == id);
        let (unit, steps_per_unit) = own.map_or(("steps", 1.0), |(_, unit)| *unit);
        AxisSheet {
            axis: id.number(),
            unit,
            steps_per_unit,
            switch: switches >> id.index() & 1 != 0,
            home_within: board.home_within.iter().find(|(one, _)| *one == id).map(|(_, far)| *far),
        }
    };
    Ok(BoardSheet {
        name: board.name.clone(),
        protocol: info.map(|info| format!("{}.{}", info.version.0, info.version.1)),
        can: info.and_then(abilities).unwrap_or_default(),
        max_speed: info.map(|info| info.max),
        axes: AxisId::first(info.map_or(1, |info| info.axes)).map(axis).collect(),
        settings: listed.as_ref().map_or_else(Vec::new, settings),
        machine: board.machine.clone(),
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
