use super::*;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::process::Command;

fn folder() -> (tempfile::TempDir, Folder) {
    let directory = tempfile::tempdir().unwrap();
    let folder = Folder::open(directory.path()).unwrap();
    (directory, folder)
}

#[test]
fn files_appear_whole_and_are_read_back() {
    let (_directory, folder) = folder();
    folder.publish("a", b"one").unwrap();
    folder.publish("a", b"two").unwrap();
    assert_eq!(folder.read("a", 3).unwrap(), b"two");
    assert!(!folder.publish_first("a", b"three").unwrap());
    assert!(folder.publish_first("b", b"three").unwrap());
    assert_eq!(folder.names().unwrap(), ["a", "b"]);
    assert!(folder.read("a", 2).unwrap_err().to_string().contains("more than 2 bytes"));
    assert!(folder.read_if_there("c", 2).unwrap().is_none());
}

#[test]
fn what_is_no_ordinary_file_is_refused_at_once() {
    let (directory, folder) = folder();
    folder.publish("file", b"text").unwrap();
    symlink("file", directory.path().join("link")).unwrap();
    fs::create_dir(directory.path().join("directory")).unwrap();
    let made = Command::new("mkfifo").arg(directory.path().join("pipe")).status().unwrap();
    assert!(made.success());
    for (name, why) in [("link", "it is a link"), ("directory", "not an ordinary"), ("pipe", "not an ordinary")] {
        assert!(folder.read(name, 100).unwrap_err().to_string().contains(why), "{name}");
    }
    assert!(folder.within("link").is_err() && folder.within("file").is_err());
    assert!(folder.within("directory").is_ok());
}

#[test]
fn nothing_is_written_where_the_path_leads_elsewhere() {
    let parent = tempfile::tempdir().unwrap();
    let path = parent.path().join("run");
    fs::create_dir(&path).unwrap();
    let folder = Folder::open(&path).unwrap();
    fs::rename(&path, parent.path().join("moved")).unwrap();
    fs::create_dir(&path).unwrap();
    assert!(folder.publish("a", b"one").unwrap_err().to_string().contains("was moved, removed or replaced"));
    for directory in ["run", "moved"] {
        assert_eq!(fs::read_dir(parent.path().join(directory)).unwrap().count(), 0, "{directory}");
    }
}

#[test]
fn unfinished_files_are_removed_and_directories_of_such_names_left_alone() {
    let (directory, folder) = folder();
    drop(folder.begin().unwrap());
    assert!(folder.names().unwrap().is_empty());
    fs::write(directory.path().join(format!("{PREFIX}1-2")), "half").unwrap();
    fs::create_dir(directory.path().join(format!("{PREFIX}3"))).unwrap();
    folder.publish("a", b"one").unwrap();
    folder.remove_unfinished().unwrap();
    assert_eq!(folder.names().unwrap(), [&format!("{PREFIX}3"), "a"]);
}

#[test]
fn whoever_may_read_is_left_to_the_umask() {
    let (directory, folder) = folder();
    fs::set_permissions(directory.path(), fs::Permissions::from_mode(0o777)).unwrap();
    folder.publish("a", b"one").unwrap();
    let plain = directory.path().join("b");
    fs::write(&plain, "two").unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&directory.path().join("a")), mode(&plain));
}
