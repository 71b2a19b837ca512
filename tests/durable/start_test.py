#!/usr/bin/env python3
"""Tests the start of kerfd on kept sheets: which folder, which sheets, damage to one of them, a second kerfd.

    start_test.py --kerfd KERFD --kerf KERF
"""

import contextlib
import hashlib
import json
import os
import pathlib
import shutil
import sqlite3
import subprocess

from kept_case import OPTIONS, Case, main
from server import LISTEN, line_cut, reason, scene


def contents(folder):
    """Returns the sums of all files of a folder. The lock is left out, as it names the process that looks."""
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in pathlib.Path(folder).rglob("*")
            if path.is_file() and path.name != "lock"}


def change_bytes(folder, table, column, sheet_id):
    """Flips the bits of the last byte of a column in all rows of a sheet."""
    with contextlib.closing(sqlite3.connect(folder / "kerf.db")) as database:
        sheet, = database.execute("SELECT sheet FROM sheets WHERE id = ?", (sheet_id,)).fetchone()
        key = "seq" if table == "journal" else "sheet"
        rows = database.execute(f"SELECT {key}, {column} FROM {table} WHERE sheet = ?", (sheet,)).fetchall()
        for number, content in rows:
            changed = content[:-1] + bytes([content[-1] ^ 0xff])
            database.execute(f"UPDATE {table} SET {column} = ? WHERE sheet = ? AND {key} = ?", (changed, sheet, number))
        database.commit()
    return len(rows)


class Folder(Case):
    def test_without_a_name_it_is_the_data_folder_of_the_user(self):
        home, data = self.folder / "home", self.folder / "data"
        for given, expected in (("", home / ".local/share/kerf"), (data, data / "kerf"), ("data", home / ".local/share/kerf")):
            server = self.start(environment={"HOME": str(home), "XDG_DATA_HOME": str(given)}, data=False)
            self.assertEqual(server.ready["data"], str(expected))
            self.assertEqual(expected.stat().st_mode & 0o777, 0o700)
            self.assertTrue((expected / "kerf.db").is_file())
            self.stop(server)

    def test_without_a_home_a_folder_has_to_be_named(self):
        for home in ({}, {"HOME": ""}):
            done = subprocess.run([OPTIONS["kerfd"], *LISTEN], env=home, capture_output=True, text=True, timeout=60)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertIn("give --data DIR, or --data none", done.stderr)

    def test_a_store_that_is_removed_while_it_runs_ends_kerfd(self):
        for remove in (lambda: shutil.rmtree(self.store), lambda: (self.store / "kerf.db").unlink()):
            server = self.start()
            self.make(server, "a")
            remove()
            server.call("CutService/CreateCut", line_cut("sheets/a", (-1, 0.5), (2, 0.5)))
            self.assertIn("removed or replaced by another program", server.ended())
            self.assertEqual(server.process.returncode, 70)
            self.running.remove(server)
            shutil.rmtree(self.store, ignore_errors=True)

    def test_files_of_others_in_its_folder_stop_nothing(self):
        server = self.start()
        self.make(server, "a")
        self.stop(server)
        (self.store / "states/old").mkdir()
        (self.store / "states/notes.txt").touch()
        (self.store / "states/old.state").mkdir()
        self.assertEqual(self.names(self.start()), ["sheets/a"])
        self.assertEqual(sorted(path.name for path in (self.store / "states").iterdir())[-3:], ["notes.txt", "old", "old.state"])

    def test_none_keeps_nothing(self):
        server = self.start("--data", "none", environment={"HOME": str(self.folder), "XDG_DATA_HOME": ""}, data=False)
        self.assertNotIn("data", server.ready)
        self.make(server, "a")
        self.stop(server)
        self.assertEqual(contents(self.folder), {})

    def test_a_second_kerfd_is_refused_and_does_no_harm(self):
        first = self.start()
        self.make(first, "a")
        self.cut(first, "a")
        before = contents(self.store / "states")
        second = self.run_kerfd(*LISTEN, "--data", self.store)
        self.assertEqual((second.returncode, second.stdout), (2, ""))
        self.assertIn(f"is used by process {first.process.pid};", second.stderr)
        self.assertEqual(contents(self.store / "states"), before)
        later = self.cut(first, "a", 0.6)
        self.kill(first)
        self.assertIn(later, self.cuts(self.start(), "a"))


class Continuing(Case):
    def write_scene(self, side):
        path = self.folder / "scene.json"
        path.write_text(json.dumps(scene(side, sheet_id="stage")))
        return path

    def vertices(self, server):
        return self.get(server, "stage")["num_vertices"]

    def test_a_scene_that_no_client_has_changed_is_made_from_its_file(self):
        server = self.start("--scene", self.write_scene(8))
        created = self.get(server, "stage")["created_unix_us"]
        self.stop(server)
        server = self.start("--scene", self.write_scene(9))
        self.assertEqual((self.names(server), self.vertices(server)), (["sheets/stage"], 81))
        self.assertNotEqual(self.get(server, "stage")["created_unix_us"], created)

    def test_a_changed_scene_continues_unless_it_is_to_be_fresh(self):
        server = self.start("--scene", self.write_scene(8))
        cut = self.cut(server, "stage")
        changed = self.get(server, "stage")
        self.stop(server)
        server = self.start("--scene", self.write_scene(9))
        self.assertEqual(self.cuts(server, "stage"), [cut])
        for field in ("created_unix_us", "num_vertices", "pieces"):
            self.assertEqual(self.get(server, "stage")[field], changed[field])
        self.stop(server)
        server = self.start("--scene", self.write_scene(9), "--fresh")
        self.assertEqual((self.cuts(server, "stage"), self.vertices(server)), ([], 81))
        self.stop(server)
        self.assertEqual(self.vertices(self.start()), 81)

    def test_a_start_that_fails_loses_nothing(self):
        server = self.start("--scene", self.write_scene(8))
        cut = self.cut(server, "stage")
        self.stop(server)
        other = self.folder / "other.json"
        other.write_text(json.dumps(scene(5, sheet_id="other")))
        broken = self.folder / "broken.json"
        broken.write_text("{")
        taken = self.start("--data", "none", data=False)
        http = taken.ready["http"].removeprefix("http://")
        for options in (("--scene", self.folder / "none.json"), ("--scene", broken), ("--scene", self.write_scene(8)),
                        ("--scene", other, "--max-sheets", "1"), ("--scene", other, "--http", http)):
            for fresh in (("--fresh",), ()):
                with self.subTest(options=options, fresh=fresh):
                    refused = self.run_kerfd(*LISTEN, "--data", self.store, "--scene", self.write_scene(9), *options, *fresh)
                    self.assertEqual(refused.returncode, 2, refused.stderr)
                    server = self.start()
                    self.assertEqual((self.names(server), self.cuts(server, "stage")), (["sheets/stage"], [cut]))
                    self.kill(server)
        self.refused("give one of them another sheet_id", *LISTEN, "--data", self.folder / "x", "--scene", other, "--scene", other)

    def test_what_counts_as_a_change_of_a_scene(self):
        stage = "sheets/stage"
        changes = {
            "a saved state": [("SheetService/SaveState", {"parent": stage, "state_id": "mine"})],
            "a pause": [("SheetService/PauseSheet", {"name": stage}), ("SheetService/StepSheet", {"name": stage, "ticks": 2})],
            "a speed": [("SheetService/SetSheetSpeed", {"name": stage, "speed": 0.5})],
            "a scheduled cut": [("CutService/CreateCut", {**line_cut(stage, (-1, 0.4), (2, 0.4)), "at_tick": 1_000_000})],
        }
        for name, requests in changes.items():
            with self.subTest(name):
                server = self.start("--scene", self.write_scene(8), "--fresh")
                for method, message in requests:
                    self.done(server, method, message)
                self.kill(server)
                server = self.start("--scene", self.write_scene(9))
                self.assertEqual(self.vertices(server), 64)
                self.stop(server)

    def test_an_empty_name_of_a_folder_is_refused(self):
        for option in ("--data", "--check-store", "--restore-store", "--backups"):
            self.refused("is empty; name a folder", *LISTEN, option, "")

    def test_options_that_would_be_ignored_are_refused(self):
        for options, says in (
                (("--check-store", self.store, "--restore-store", "x"), "leave --restore-store out"),
                (("--check-store", self.store, "--fresh"), "leave --fresh out"),
                (("--restore-store", "x", "--data", self.store, "--scene", "y"), "leave --scene out"),
                (("--data", "none", "--fresh", "--scene", "x"), "--fresh: with --data none nothing is kept"),
                (("--data", "none", "--max-replay-s", "3"), "--max-replay-s: with --data none nothing is kept"),
                (("--data", self.store, "--fresh"), "give --scene FILE as well")):
            self.refused(says, *options)
        self.assertFalse(self.store.exists())

    def test_the_ready_line_names_the_folder_from_the_root(self):
        server = self.start("--data", os.path.relpath(self.store), data=False)
        self.assertEqual(server.ready["data"], str(self.store))

    def test_a_sheet_keeps_the_time_of_its_making(self):
        server = self.start()
        self.make(server, "a")
        made = self.listed_by_kerf(server)
        self.stop(server)
        server = self.start()
        self.assertEqual(self.listed_by_kerf(server), made)
        self.kill(server)
        self.assertEqual(self.listed_by_kerf(self.start()), made)

    def listed_by_kerf(self, server):
        command = [OPTIONS["kerf"], "--server", server.ready["grpc"], "--json", "sheet", "list"]
        listed = json.loads(subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout)
        return [(sheet["name"], sheet["created_unix_us"]) for sheet in listed["sheets"]]


class Damage(Case):
    def fill(self, names="abc"):
        """Makes sheets, cuts each and ends kerfd."""
        server = self.start()
        for name in names:
            self.make(server, name)
            self.cut(server, name)
        self.stop(server)

    def test_a_damaged_sheet_is_set_aside_and_all_others_start(self):
        for table, column in (("journal", "content"), ("sheets", "scene")):
            with self.subTest(table):
                self.store = self.folder / table
                self.fill()
                self.assertGreater(change_bytes(self.store, table, column, "b"), 0)
                for words in ("is damaged and set aside", "is set aside"):
                    server = self.start()
                    self.assertEqual(self.names(server), ["sheets/a", "sheets/c"])
                    self.assertEqual([len(self.cuts(server, name)) for name in "ac"], [1, 1])
                    self.assertEqual(reason(self.get(server, "b")), "SHEET_NOT_FOUND")
                    self.assertIn(f'kerfd: the kept sheet "b" {words}: ', self.stop(server))

    def test_the_name_of_a_sheet_that_is_set_aside_is_free(self):
        self.fill()
        change_bytes(self.store, "journal", "content", "b")
        server = self.start()
        self.make(server, "b", 9)
        self.stop(server)
        server = self.start()
        self.assertEqual((self.names(server), self.get(server, "b")["num_vertices"]), (["sheets/a", "sheets/b", "sheets/c"], 81))
        self.assertIn('the kept sheet "b" is set aside', self.stop(server))

    def test_a_check_finds_damage_and_changes_nothing(self):
        self.fill()
        good = self.run_kerfd("--check-store", self.store)
        self.assertEqual((good.returncode, good.stderr), (0, ""))
        self.assertRegex(good.stdout, r"^3 sheets, 0 set aside, 3 changes, \d+ states, \d+ answers; 0 faults\n$")
        change_bytes(self.store, "journal", "content", "b")
        before = contents(self.store)
        bad = self.run_kerfd("--check-store", self.store)
        self.assertEqual(bad.returncode, 1)
        self.assertRegex(bad.stdout, r'(?m)^fault: sheet 2 "b": entry \d+ of sheet 2 ')
        self.assertRegex(bad.stdout, r"; 1 fault\n$")
        self.assertEqual(contents(self.store), before)
        server = self.start()
        in_use = self.run_kerfd("--check-store", self.store)
        self.assertEqual((in_use.returncode, in_use.stdout), (2, ""))
        self.assertIn(f"is used by process {server.process.pid};", in_use.stderr)
        self.stop(server)
        aside = self.run_kerfd("--check-store", self.store)
        self.assertRegex(aside.stdout, r"(?m)^3 sheets, 1 set aside, ")

    def test_a_check_after_a_kill_changes_nothing(self):
        server = self.start()
        self.make(server, "a")
        self.cut(server, "a")
        self.kill(server)
        before = contents(self.store)
        self.assertIn("kerf.db-wal", before)
        killed = self.run_kerfd("--check-store", self.store)
        self.assertRegex(killed.stdout, r"^1 sheet, 0 set aside, 1 change, .*; 0 faults\n$")
        self.assertEqual(contents(self.store), before)

    def test_no_store_is_no_good_store(self):
        (self.folder / "empty").mkdir()
        (self.folder / "empty/kerf.db").touch()
        (self.folder / "file").touch()
        before = contents(self.folder)
        for name, says in (("none", "DATA/backups/ID"), ("empty", "no sheet was ever kept there"), ("file", "there is no store")):
            none = self.run_kerfd("--check-store", self.folder / name)
            self.assertEqual((none.returncode, none.stdout), (2, ""))
            self.assertIn("--check-store: ", none.stderr)
            self.assertIn(says, none.stderr)
        self.assertEqual(contents(self.folder), before)
        self.refused("Not a directory", *LISTEN, "--data", self.folder / "file")

    def change(self, sql, *values):
        with contextlib.closing(sqlite3.connect(self.store / "kerf.db")) as database:
            database.execute(sql, values)
            database.commit()

    def test_changes_before_the_newest_state_are_not_needed(self):
        """A sheet continues without them, says so, and takes more changes. A backup of it can be restored."""
        for number, sql in enumerate(("UPDATE journal SET tick = tick + 1 WHERE seq = 1", "DELETE FROM journal WHERE seq = 1",
                                      "DELETE FROM journal WHERE seq = 2")):
            with self.subTest(sql):
                self.store = self.folder / str(number)
                server = self.start()
                self.make(server, "a")
                self.cut(server, "a")
                self.done(server, "SheetService/SaveState", {"parent": "sheets/a", "state_id": "s"})
                self.done(server, "SheetService/RestoreState", {"name": "sheets/a/states/s"})
                self.stop(server)
                self.change(sql)
                server = self.start()
                self.cut(server, "a", 0.6)
                self.done(server, "StoreService/BackupStore", {"backup_id": "b"})
                self.assertIn('kerfd: the kept sheet "a" continues, and cannot be repeated from its beginning: ', self.stop(server))
                self.assertEqual(len(self.cuts(self.start(), "a")), 2)
                restored = self.run_kerfd("--restore-store", self.store / "backups/b", "--data", self.store / "again")
                self.assertEqual((restored.returncode, restored.stderr), (1, ""))
                self.assertRegex(restored.stdout, r'(?m)^fault: sheet 1 "a": ')
                self.store = self.store / "again"
                self.assertEqual(len(self.cuts(self.start(), "a")), 2)

    def test_damaged_answers_are_counted_and_left_out(self):
        server = self.start()
        self.done(server, "SheetService/CreateSheet", {"sheet_id": "a", "scene": scene(8), "request_id": "once"})
        self.stop(server)
        self.change("UPDATE requests SET at = at + 1")
        server = self.start()
        self.done(server, "StoreService/BackupStore", {"backup_id": "b"})
        self.assertIn("1 kept answers are damaged and left out", self.stop(server))
        restored = self.run_kerfd("--restore-store", self.store / "backups/b", "--data", self.folder / "again")
        self.assertEqual((restored.returncode, restored.stdout.splitlines()[0]), (1, "fault: 1 answers have changed since they were written"))

    def test_a_damaged_state_that_cannot_be_moved_stops_nothing(self):
        server = self.start()
        self.make(server, "a")
        for state in ("first", "second"):
            self.done(server, "SheetService/SaveState", {"parent": "sheets/a", "state_id": state})
        self.stop(server)
        for file in (self.store / "states").iterdir():
            file.write_bytes(b"torn")
        (self.store / "damaged").touch()
        for _ in range(2):
            server = self.start()
            self.assertEqual(self.names(server), ["sheets/a"])
            text = self.stop(server)
            for state in ("first", "second"):
                self.assertRegex(text, rf'continues without a state: the file of the saved state "{state}".* it stays, as this server cannot make')

    def test_a_saved_state_that_is_damaged_is_named_once_and_then_forgotten(self):
        for change in ("changed", "gone"):
            with self.subTest(change):
                self.store = self.folder / change
                server = self.start()
                self.make(server, "a")
                for state in ("before", "later"):
                    self.done(server, "SheetService/SaveState", {"parent": "sheets/a", "state_id": state})
                self.cut(server, "a")
                self.stop(server)
                with contextlib.closing(sqlite3.connect(self.store / "kerf.db")) as database:
                    sheet, seq, number = database.execute("SELECT sheet, seq, number FROM states WHERE name = 'before'").fetchone()
                file = self.store / "states" / f"{sheet}-{seq}-{number}.state"
                damaged = bytearray(file.read_bytes())
                damaged[99] ^= 1
                if change == "gone":
                    file.unlink()
                else:
                    file.write_bytes(damaged)
                found = self.run_kerfd("--check-store", self.store)
                self.assertIn('fault: sheet 1 "a": the file of the saved state "before"', found.stdout)
                server = self.start()
                listed = self.done(server, "SheetService/ListStates", {"parent": "sheets/a"})
                self.assertEqual([state["name"] for state in listed["states"]], ["sheets/a/states/later"])
                self.assertEqual(len(self.cuts(server, "a")), 1)
                self.done(server, "StoreService/BackupStore", {"backup_id": "whole"})
                self.assertIn('kerfd: the kept sheet "a" continues without a state: the file of the saved state "before"',
                              self.stop(server))
                kept = self.store / "damaged" / file.name
                self.assertEqual(kept.read_bytes() if kept.exists() else b"", damaged if change == "changed" else b"")
                self.assertEqual(self.run_kerfd("--check-store", self.store).returncode, 0)
                self.assertNotIn("without a state", self.stop(self.start()))


if __name__ == "__main__":
    main(__doc__)
