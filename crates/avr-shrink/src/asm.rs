//! Assembly as LLVM writes it: functions and the text between them.

use std::fmt;

/// A line of a function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Line {
    /// `name:`
    Label(String),
    /// An instruction of the compiler.
    Code(Code),
    /// Anything else: directives, and hand-written assembly.
    Other(String),
}

/// An instruction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Code {
    /// The mnemonic, such as `ldd`.
    pub name: String,
    /// The first operand, such as `r24`, or nothing.
    pub a: String,
    /// The second operand, such as `Y+3`, or nothing.
    pub b: String,
}

impl Code {
    /// Reads `ldd r24, Y+3`.
    pub fn parse(text: &str) -> Code {
        let (name, operands) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let (a, b) = operands.split_once(',').unwrap_or((operands, ""));
        Code { name: name.into(), a: a.trim().into(), b: b.trim().into() }
    }

    /// Whether it is the instruction in `text`.
    pub fn is(&self, text: &str) -> bool {
        *self == Code::parse(text)
    }

    /// Whether it may skip the next instruction.
    pub fn skips(&self) -> bool {
        matches!(&*self.name, "sbrs" | "sbrc" | "sbis" | "sbic" | "cpse")
    }

    /// The largest size in words: the linker shortens most calls and jumps.
    pub fn words(&self) -> i32 {
        match &*self.name {
            "call" | "jmp" | "lds" | "sts" => 2,
            _ => 1,
        }
    }

    /// Whether its target is given by a distance, as in `rjmp .-4`.
    fn is_relative(&self) -> bool {
        self.a.starts_with('.') && !self.a.starts_with(".L")
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Code { name, a, b } = self;
        write!(f, "\t{name}\t{a}{}{b}", if b.is_empty() { "" } else { ", " })
    }
}

impl Line {
    /// The instruction, if the compiler wrote the line.
    pub fn code(&self) -> Option<&Code> {
        match self {
            Line::Code(code) => Some(code),
            _ => None,
        }
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Line::Label(label) => write!(f, "{label}:"),
            Line::Code(code) => write!(f, "{code}"),
            Line::Other(text) => write!(f, "{text}"),
        }
    }
}

/// A function, or the text between two functions.
#[derive(Clone, Debug)]
pub(crate) enum Part {
    /// Unchanged text.
    Text(Vec<String>),
    /// From its label to its end.
    Function(Function),
}

/// A function of the compiler.
#[derive(Clone, Debug)]
pub(crate) struct Function {
    /// Its symbol.
    pub name: String,
    /// The first line is the function's label.
    pub lines: Vec<Line>,
}

impl Function {
    /// The instructions, each with its line number.
    pub fn code(&self) -> impl Iterator<Item = (usize, &Code)> {
        self.lines.iter().enumerate().filter_map(|(at, line)| Some((at, line.code()?)))
    }

    /// Whether the instruction before the line may skip it.
    pub fn is_skipped(&self, line: usize) -> bool {
        line > 0 && self.lines[line - 1].code().is_some_and(Code::skips)
    }

    /// Whether all of it is hand-written: it ends an interrupt, jumps by distances, or has labels
    /// that the compiler does not make.
    fn is_by_hand(&self) -> bool {
        self.lines.iter().skip(1).any(|line| match line {
            Line::Label(name) => {
                let number = name.strip_prefix(".LBB").or(name.strip_prefix(".L"));
                !number.is_some_and(|number| number.starts_with(|c: char| c.is_ascii_digit()))
            }
            Line::Code(code) => code.name == "reti" || code.is_relative(),
            Line::Other(_) => false,
        })
    }
}

/// A program's assembly.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    /// The parts, in order.
    pub parts: Vec<Part>,
}

impl Program {
    /// Reads the assembly that rustc writes with `--emit=asm`.
    pub fn parse(text: &str) -> Program {
        let mut parts = Vec::new();
        let mut between = Vec::new();
        let mut lines = text.lines();
        // The function whose `.type` has been read, and whose label is expected.
        let mut named: Option<&str> = None;
        while let Some(line) = lines.next() {
            // The GNU assembler does not support several sections of one name.
            let line = line.split(",unique,").next().unwrap_or(line);
            between.push(line.to_string());
            named = typed(line).or(named);
            if named.is_none() || line.trim().strip_suffix(':') != named {
                continue;
            }
            between.pop();
            let name = named.take().unwrap_or_default().to_string();
            parts.push(Part::Text(std::mem::take(&mut between)));
            let mut function = Function { lines: vec![Line::Label(name.clone())], name };
            let mut foreign = false;
            for line in lines.by_ref() {
                // A hand-written function may have no end: the next one begins.
                named = typed(line);
                if named.is_some() || line.starts_with(".Lfunc_end") {
                    between.push(line.to_string());
                    break;
                }
                function.lines.extend(self::line(line, &mut foreign));
            }
            parts.push(match named.is_some() || function.is_by_hand() {
                true => Part::Text(function.lines.iter().map(Line::to_string).collect()),
                false => Part::Function(function),
            });
        }
        parts.push(Part::Text(between));
        Program { parts }
    }

    /// All functions, for changing.
    pub fn functions_mut(&mut self) -> impl Iterator<Item = &mut Function> {
        self.parts.iter_mut().filter_map(|part| match part {
            Part::Function(function) => Some(function),
            Part::Text(_) => None,
        })
    }

    /// Appends assembly.
    pub fn append(&mut self, text: &str) {
        self.parts.push(Part::Text(text.lines().map(Into::into).collect()));
    }
}

/// The function that a `.type` announces.
fn typed(line: &str) -> Option<&str> {
    line.trim().strip_prefix(".type")?.trim().strip_suffix(",@function")
}

/// The instruction on a line of text; `None` for a label, a directive or a comment.
pub(crate) fn instruction(line: &str) -> Option<Code> {
    let plain = line.split(';').next().unwrap_or("").trim();
    let other = plain.is_empty() || plain.starts_with('.') || plain.ends_with(':');
    (!other).then(|| Code::parse(plain))
}

/// The label of a line of text.
pub(crate) fn label(line: &str) -> Option<&str> {
    line.split(';').next().unwrap_or("").trim().strip_suffix(':')
}

/// Reads a line of a function; `foreign` is true inside hand-written assembly.
fn line(text: &str, foreign: &mut bool) -> Option<Line> {
    let trimmed = text.trim();
    *foreign |= trimmed == ";APP";
    if *foreign {
        *foreign = trimmed != ";NO_APP";
        return Some(Line::Other(text.into()));
    }
    if trimmed.starts_with('.') && label(text).is_none() {
        return Some(Line::Other(text.into()));
    }
    label(text).map(|label| Line::Label(label.into())).or_else(|| instruction(text).map(Line::Code))
}

impl fmt::Display for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for part in &self.parts {
            match part {
                Part::Text(lines) => lines.iter().try_for_each(|line| writeln!(f, "{line}"))?,
                Part::Function(function) => {
                    function.lines.iter().try_for_each(|line| writeln!(f, "{line}"))?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\t.section\t.text.f,\"ax\",@progbits,unique,3
by_hand:
\tnop ; stays
\t.type\tf,@function
f:
\tldi\tr24, 1 ; one
\t;APP
\tcli
\t;NO_APP
.L1:
\trjmp\t.L1
.Lfunc_end0:
\t.size\tf, .Lfunc_end0-f
\t.type\tDATA,@object
DATA:
\t.ascii\t\"a;b\"
";

    #[test]
    fn only_the_compilers_functions_are_read() {
        let program = Program::parse(TEXT);
        let [Part::Text(_), Part::Function(f), Part::Text(_)] = &*program.parts else {
            panic!("{program:?}")
        };
        assert_eq!(f.name, "f");
        let code: Vec<_> = f.code().map(|(at, code)| (at, code.to_string())).collect();
        assert_eq!(code, [(1, "\tldi\tr24, 1".into()), (6, "\trjmp\t.L1".into())]);
    }

    #[test]
    fn one_by_hand_without_an_end_ends_where_the_next_begins() {
        let by_hand = "\t.type\thandler,@function\nhandler:\n\tnop\t\n\t.section\t.text.f\n";
        let program = Program::parse(&format!("{by_hand}{TEXT}"));
        assert!(program.to_string().starts_with(by_hand));
        let functions: Vec<_> = program.clone().functions_mut().map(|f| f.name.clone()).collect();
        assert_eq!(functions, ["f"]);
    }

    #[test]
    fn the_rest_is_written_as_it_was() {
        let written = Program::parse(TEXT).to_string();
        assert_eq!(written, TEXT.replace(",unique,3", "").replace(" ; one", ""));
    }
}
