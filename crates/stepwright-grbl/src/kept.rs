//! The values that outlast a loss of power, as text: settings, work offsets, start-up lines.

use stepwright_gcode::{Length, Parameter, Point, System};

use crate::machine::GrblMachine;
use crate::session::Grbl;
use crate::settings::GrblSettings;

/// The parameters that are kept.
pub(crate) const PARAMETERS: [Parameter; 8] = [
    Parameter::System(System::G54),
    Parameter::System(System::G55),
    Parameter::System(System::G56),
    Parameter::System(System::G57),
    Parameter::System(System::G58),
    Parameter::System(System::G59),
    Parameter::G28,
    Parameter::G30,
];

fn name(parameter: Parameter) -> String {
    match parameter {
        Parameter::System(system) => format!("G{}", 54 + system as u8),
        Parameter::G30 => "G30".to_owned(),
        _ => "G28".to_owned(),
    }
}

/// A text that can't be restored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotKept {
    /// The line, from 1.
    pub line: usize,
}

impl std::fmt::Display for NotKept {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let line = self.line;
        write!(
            f,
            "line {line} is no kept value: a setting as $100=250.000, an offset in picometres as \
             G54=0,0,0, $N0=LINE or $I=WORDS"
        )
    }
}

impl std::error::Error for NotKept {}

impl<M: GrblMachine> Grbl<M> {
    /// The values that outlast a loss of power, one a line; [`restore`](Grbl::restore) reads them.
    ///
    /// Offsets are exact, in picometres.
    pub fn kept(&self) -> String {
        let settings = GrblSettings::numbers().filter_map(|number| {
            let value = self.settings.get(number);
            self.settings.line(number).map(|_| format!("${number}={value}\n"))
        });
        let offsets = PARAMETERS.map(|parameter| {
            let reader = self.unchecked.as_ref().unwrap_or(&self.reader);
            let [x, y, z] = reader.parameter(parameter).0.map(Length::picometres);
            format!("{}={x},{y},{z}\n", name(parameter))
        });
        let lines = [0, 1].map(|which| format!("$N{which}={}\n", self.startup[which]));
        let build = format!("$I={}\n", self.build);
        settings.chain(offsets).chain(lines).chain([build]).collect()
    }

    /// Restarts the machine with values that were kept. With homing (`$22`) it is locked then,
    /// because its position is not known.
    ///
    /// # Errors
    /// [`NotKept`] at the first line that is wrong; nothing is changed then.
    pub fn restore(&mut self, kept: &str) -> Result<(), NotKept> {
        let mut settings = GrblSettings::default();
        let mut reader = stepwright_gcode::Reader::default();
        let (mut startup, mut build) = ([String::new(), String::new()], String::new());
        // Soft limits need homing, whose setting comes later in the text.
        let all: Vec<(usize, &str)> = kept.lines().enumerate().collect();
        let (soft, others): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|(_, line)| line.starts_with("$20="));
        for (n, line) in others.into_iter().chain(soft) {
            let wrong = NotKept { line: n + 1 };
            let Some((name, value)) = line.split_once('=') else { return Err(wrong) };
            match (name, name.strip_prefix('$')) {
                ("$N0", _) => value.clone_into(&mut startup[0]),
                ("$N1", _) => value.clone_into(&mut startup[1]),
                ("$I", _) => value.clone_into(&mut build),
                (_, Some(number)) => set(&mut settings, number, value).ok_or(wrong)?,
                (_, None) => offset(&mut reader, name, value).ok_or(wrong)?,
            }
        }
        (self.settings, self.reader, self.startup, self.build) = (settings, reader, startup, build);
        self.motion.drop_at(self.motion.at);
        (self.after, self.unchecked) = (None, None);
        _ = self.take_answers();
        self.restart_as(self.settings.is_on(22));
        Ok(())
    }
}

fn set(settings: &mut GrblSettings, number: &str, value: &str) -> Option<()> {
    settings.set(number.parse().ok()?, value.parse().ok()?).ok()
}

fn offset(reader: &mut stepwright_gcode::Reader, of: &str, value: &str) -> Option<()> {
    let parameter = PARAMETERS.into_iter().find(|parameter| name(*parameter) == of)?;
    let mut axes = [Length::ZERO; 3];
    let mut numbers = value.split(',');
    for axis in &mut axes {
        *axis = Length::from_picometres(numbers.next()?.parse().ok()?)?;
    }
    reader.set_parameter(parameter, Point(axes));
    numbers.next().is_none().then_some(())
}
