"""`kerf store` and `kerfd --restore-store`: what is kept is looked at, pruned and copied while kerfd runs, and a copy continues."""

import json
import os
import pathlib
import shutil
import signal
import sqlite3
import subprocess

import cli_case
from cli_case import Case, kerf, main, path


def setUpModule():
    shutil.rmtree(cli_case.OPTIONS.work, ignore_errors=True)
    os.makedirs(cli_case.OPTIONS.work)


def kerfd(*options):
    """Runs a kerfd that ends by itself."""
    return subprocess.run([cli_case.OPTIONS.kerfd, *options], capture_output=True, text=True, timeout=60)


class Store(Case):
    def start(self, *options):
        """Starts a kerfd, which the commands after this are sent to."""
        with open(path("notes"), "w", encoding="utf-8") as notes:
            process = subprocess.Popen(
                [cli_case.OPTIONS.kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--no-render", "--max-load", "0", *options],
                stdout=subprocess.PIPE, stderr=notes, text=True)
        self.addCleanup(self.end, process)
        cli_case.SERVER = json.loads(process.stdout.readline())
        return process

    def end(self, process, number=signal.SIGTERM):
        if process.poll() is None:
            process.send_signal(number)
            process.wait(timeout=20)
        process.stdout.close()

    def folder(self):
        """Returns a new folder's name, one for each test."""
        return path(self.id().rsplit(".", 1)[-1])

    def restore_fails(self, backup, data, says):
        done = kerfd("--restore-store", backup, "--data", data)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn(says, done.stderr)

    def test_a_backup_of_a_running_server_continues_elsewhere(self):
        data, elsewhere = self.folder(), self.folder() + "-elsewhere"
        process = self.start("--data", data)
        self.json_of("sheet", "create", "kept", "--grid", "9x9", "--paused")
        self.json_of("cut", "kept", "--circle", "0.3,0.3,0.1")
        made = self.json_of("store", "backup", "first")
        self.assertEqual((made["backup_id"], made["folder"]), ("first", f"{data}/backups/first"))
        self.assertGreater(made["num_bytes"], 10_000)
        first = self.json_of("sheet", "get", "kept")
        self.assertEqual(self.json_of("cut", "kept", "--circle", "0.7,0.7,0.1")["pieces"], 3)
        self.end(process, signal.SIGKILL)

        done = kerfd("--restore-store", made["folder"], "--data", elsewhere)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertRegex(done.stdout, rf'^restored 1 sheet, 0 set aside, 2 changes, 0 states, 0 answers into "{elsewhere}"\n$')
        self.assertEqual(kerfd("--check-store", elsewhere).returncode, 0)
        self.start("--data", elsewhere)
        self.assertNotIn("kept sheet", pathlib.Path(path("notes")).read_text())
        sheet = self.json_of("sheet", "get", "kept")
        self.assertEqual((sheet["pieces"], sheet["state_hash"]), (2, first["state_hash"]))
        self.start("--data", data)
        self.assertEqual(self.json_of("sheet", "get", "kept")["pieces"], 3)

        self.restore_fails(made["folder"], data, "is not empty")
        self.restore_fails(made["folder"], made["folder"] + "/a/b", "lies in the backup itself")
        self.assertEqual(kerfd("--restore-store", made["folder"], "--data", elsewhere + "/below/deep").returncode, 0)
        self.assertEqual(kerfd("--check-store", elsewhere + "/below/deep").returncode, 0)

    def test_backups_have_plain_names_and_are_bounded(self):
        backups = self.folder() + "-backups"
        self.start("--data", self.folder(), "--backups", backups + "/")
        for wrong in ("", "Monday", "../monday", "a.b", "a" * 64):
            self.refused("store", "backup", wrong, says="BACKUP_ID")
        self.assertFalse(os.path.exists(backups))
        os.makedirs(f"{backups}/left.part")  # as a kill leaves it
        os.makedirs(f"{backups}/something-else")
        for number in range(16):
            self.assertIn(f"{backups}/{number}: ", kerf("store", "backup", str(number)).stdout)
        self.refused("store", "backup", "7", says="BACKUP_EXISTS")
        self.refused("store", "backup", "left", says="TOO_MANY_BACKUPS")
        shutil.rmtree(f"{backups}/7")
        self.json_of("store", "backup", "left")
        info = self.json_of("store", "info")
        self.assertEqual((len(info["backup_ids"]), info["max_backups"]), (16, 16))
        self.assertIn("left", info["backup_ids"])
        self.assertEqual(sorted({*os.listdir(backups)} - {"something-else"}), info["backup_ids"])

    def test_a_folder_of_backups_is_checked_at_the_start(self):
        data = self.folder()
        os.makedirs(data + "-place")
        pathlib.Path(data + "-place/file").touch()
        for backups, says in ((data, "used by the store itself"), (data + "/", "used by the store itself"),
                              (f"{data}/states", "used by the store itself"), (f"{data}/x/../states/y", "used by the store itself"),
                              (os.path.dirname(data), "has the folder of --data in it"), (data + "-place/file", "cannot be a folder"), (data + "-place/file/x", "cannot be a folder"),
                              ("/dev/null", "cannot be a folder")):
            done = kerfd("--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--data", data, "--backups", backups)
            self.assertEqual((done.returncode, done.stdout), (2, ""), backups)
            self.assertIn("--backups: ", done.stderr)
            self.assertIn(says, done.stderr)
        self.assertFalse(os.path.exists(data))
        # One that becomes useless later is named, and the rest is still shown.
        backups = data + "-place/new/deep"
        self.start("--data", data, "--backups", backups)
        self.json_of("store", "backup", "a")
        shutil.rmtree(backups)
        pathlib.Path(backups).touch()
        self.assertEqual(self.json_of("store", "info")["backup_ids"], [])
        self.refused("store", "backup", "b", says="kerfd --backups")

    def test_the_store_is_shown_and_pruned(self):
        data = self.folder()
        process = self.start("--data", data)
        for name in ("torn", "whole", "gone"):
            self.json_of("sheet", "create", name, "--grid", "5x5", "--paused")
            self.json_of("cut", name, "--circle", "0.5,0.5,0.2")
        self.json_of("sheet", "delete", "gone")
        info = self.json_of("store", "info")
        self.assertEqual((info["folder"], info["sheets"], info["set_aside"]), (data, 2, []))
        self.assertGreaterEqual(info["changes"], 2)
        self.assertEqual((info["waiting_changes"], info["backup_ids"]), (0, []))
        self.end(process)
        with sqlite3.connect(f"{data}/kerf.db") as database:
            database.execute("UPDATE journal SET tick = tick + 1 WHERE sheet = (SELECT sheet FROM sheets WHERE id = 'torn')")
        database.close()
        self.start("--data", data)
        self.assertIn("torn", pathlib.Path(path("notes")).read_text())
        info = self.json_of("store", "info")
        self.assertEqual([sheet["sheet_id"] for sheet in info["set_aside"]], ["torn"])
        self.assertIn("has changed", info["set_aside"][0]["reason"])
        shown = kerf("store", "info").stdout
        self.assertRegex(shown, r"2 sheets, 1 set aside\n(.|\n)*  set aside: torn \(number \d+\): .*has changed")
        self.assertIn("kerf store delete NUMBER", shown)
        self.json_of("sheet", "create", "later", "--grid", "5x5")
        self.json_of("sheet", "delete", "later")
        self.json_of("sheet", "create", "latest", "--grid", "5x5")
        self.assertEqual(self.json_of("store", "prune"), {"removed_answers": 0, "removed_sheets": 2})
        self.assertEqual(kerf("store", "prune").stdout, "removed 0 old answers and the rest of 0 deleted sheets\n")
        # A sheet that is set aside does not make the backup useless.
        made = self.json_of("store", "backup", "torn")
        self.assertEqual(kerfd("--check-store", made["folder"]).returncode, 1)
        done = kerfd("--restore-store", made["folder"], "--data", data + "-again")
        self.assertIn("restored 3 sheets, 1 set aside", done.stdout)
        # Only sheets that are set aside are deleted, by their number.
        number = info["set_aside"][0]["number"]
        for wrong in (0, -1, number + 1, 1 << 62):
            self.refused("store", "delete", str(wrong), says="SET_ASIDE_NOT_FOUND")
        self.assertEqual(self.json_of("store", "delete", str(number)), {})
        self.refused("store", "delete", str(number), says="SET_ASIDE_NOT_FOUND")
        info = self.json_of("store", "info")
        self.assertEqual((info["sheets"], info["set_aside"]), (2, []))
        self.start("--data", data + "-again")
        self.assertEqual([sheet["sheet_id"] for sheet in self.json_of("store", "info")["set_aside"]], ["torn"])

    def test_a_damaged_backup_says_so(self):
        data, target = self.folder(), pathlib.Path(self.folder() + "-target")
        self.start("--data", data)
        self.json_of("sheet", "create", "kept", "--grid", "5x5", "--paused")
        self.json_of("sheet", "save", "kept", "before")
        folder = self.json_of("store", "backup", "a")["folder"]
        target.mkdir()
        database = pathlib.Path(folder, "kerf.db")
        whole = database.read_bytes()
        state = next(pathlib.Path(folder, "states").iterdir())
        self.restore_fails(folder, data + "/kerf.db", "is no folder")
        for file, at, says in ((database, whole.index(b"kept"), "its row has changed"), (state, 100, state.name)):
            content = bytearray(file.read_bytes())
            content[at] ^= 1
            file.write_bytes(content)
            done = kerfd("--restore-store", folder, "--data", f"{target}/{at}")
            self.assertEqual((done.returncode, done.stderr), (1, ""))
            self.assertRegex(done.stdout, rf"^fault: sheet 1.*{says}")
            self.assertIn("An older backup may have it whole", done.stdout)
            content[at] ^= 1
            file.write_bytes(content)
            shutil.rmtree(target / str(at))
        database.write_bytes(whole[:5000] + bytes(5000))
        self.restore_fails(folder, str(target), "damaged")
        database.write_bytes(whole)
        self.restore_fails(data + "/backups", str(target), "there is no store")
        self.assertEqual(list(target.iterdir()), [])
        self.assertEqual(list(target.parent.glob("*.part")), [])
        done = kerfd("--restore-store", folder, "--data", f"{target}/")
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_a_server_that_keeps_nothing(self):
        self.start("--data", "none")
        for command in (("info",), ("prune",), ("delete", "1"), ("backup", "a")):
            self.refused("store", *command, says="--data DIR")
        self.refused("store", code=2)
        self.refused("store", "backup", code=2, says="ID")
        for options, says in ((("--restore-store", "x"), "--data DIR"), (("--restore-store", "x", "--data", "none"), "--data DIR"),
                              (("--data", "none", "--backups", "x"), "--data DIR")):
            done = kerfd(*options)
            self.assertEqual(done.returncode, 2)
            self.assertIn(says, done.stderr)


if __name__ == "__main__":
    main(__doc__)
