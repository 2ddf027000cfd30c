//! Words of shell scripts.

use std::path::{Path, absolute};

use crate::failure::Failure;
use crate::shell::in_quotes;

/// A word that a POSIX shell reads as this text, whatever is in it.
pub fn quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-/+=:@,%".contains(c);
    if !text.is_empty() && !text.starts_with(['-', '=']) && text.chars().all(is_plain) {
        text.to_owned()
    } else {
        in_quotes(text)
    }
}

/// An absolute path as a text for scripts that run elsewhere. It does not begin with a dash, whatever the path does.
pub fn absolute_text(path: &Path) -> Result<String, Failure> {
    let absolute = absolute(path).map_err(|error| Failure::reading(path, error))?;
    let text = absolute.to_str().filter(|text| !text.contains('\0'));
    let text = text.ok_or_else(|| {
        Failure::CannotCreate(format!("{} is not a path in UTF-8; scripts need one", absolute.display()))
    })?;
    Ok(text.to_owned())
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn the_shell_reads_what_was_quoted() {
        for text in [
            "",
            "plain/path.toml",
            "-dash",
            "two words",
            "it's",
            "\"double\"",
            "new\nline",
            "$(id)",
            "`id`",
            "a\\b",
            "*",
            "~",
            "=ls",
            "a;b",
            "ä",
            "{}",
            "'",
            "''",
            "!",
        ] {
            let output = Command::new("sh").arg("-c").arg(format!("printf %s {}", quoted(text))).output();
            assert_eq!(String::from_utf8(output.unwrap().stdout).unwrap(), text);
        }
    }

    #[test]
    fn paths_become_absolute() {
        assert!(absolute_text(Path::new("-x/run")).unwrap().ends_with("/-x/run"));
        assert_eq!(absolute_text(Path::new("/a b/it's")).unwrap(), "/a b/it's");
    }
}
