"""Recordings of the server: written whole or not at all, and played again bit for bit; speed, materials, files."""

import os
import pathlib
import subprocess

import kerf
import support
from support import Case, path


class Recordings(Case):
    def test_a_recording_is_played_again_bit_for_bit(self):
        self.sheet.step(3)
        self.sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        self.sheet.set_gravity((0, 0, -3))
        last = self.sheet.step(5)
        written = self.sheet.record(path("run.rec"))
        self.assertEqual((os.path.getsize(path("run.rec")), os.path.exists(path("run.rec.part"))), (written, False))
        replayed = subprocess.run([support.OPTIONS.kerf, "replay", path("run.rec")], capture_output=True, text=True)
        self.assertEqual(replayed.returncode, 0, replayed.stderr)
        played = self.server.replay(path("run.rec"), "py-played", paused=True)
        self.addCleanup(played.delete)
        with self.assertRaises(kerf.FailedPrecondition) as caught:
            played.cut(kerf.circle((0.2, 0.2), 0.1))
        self.assertEqual(caught.exception.reason, "REPLAYING")
        now = played.step(last.tick)
        self.assertEqual((now.tick, now.state_hash, now.pieces), (last.tick, last.state_hash, 2))

    def test_a_torn_recording_is_played_to_its_last_whole_entry(self):
        self.sheet.step(64)
        self.sheet.step(5)
        self.sheet.record(path("torn.rec"))
        os.truncate(path("torn.rec"), os.path.getsize(path("torn.rec")) - 1)
        played = self.server.replay(path("torn.rec"), "py-torn", paused=True)
        self.addCleanup(played.delete)
        replay = played.get().replay
        self.assertEqual((replay.end_tick, replay.torn_bytes > 0), (64, True))

    def test_what_cannot_be_played_or_written(self):
        pathlib.Path(path("damaged.rec")).write_bytes(b"no recording at all")
        with self.assertRaises(kerf.InvalidArgument):
            self.server.replay(path("damaged.rec"))
        with self.assertRaises(FileNotFoundError):
            self.server.replay(path("absent.rec"))
        pathlib.Path(path("kept.rec")).write_bytes(b"of before")
        with self.assertRaises(kerf.NotFound):
            self.server.sheet("py-nobody").record(path("kept.rec"))
        self.assertEqual(pathlib.Path(path("kept.rec")).read_bytes(), b"of before")
        self.assertFalse(os.path.exists(path("kept.rec.part")))
        with self.assertRaises(FileNotFoundError):
            self.sheet.record(path("nowhere/run.rec"))

    def test_speed(self):
        self.assertEqual(self.sheet.set_speed(0.25).speed, 0.25)
        self.assertEqual(self.sheet.step(3).speed, 0.25)
        self.refused(kerf.InvalidArgument, "INVALID_ARGUMENT", "OUT_OF_RANGE", "speed", self.sheet.set_speed, 100)

    def test_materials(self):
        before = self.sheet.get().scene.material.thickness_m
        self.sheet.set_material("rubber")
        rubber = self.sheet.get().scene.material
        self.assertNotEqual(rubber.thickness_m, before)
        self.sheet.set_material({"preset": "rubber", "thickness_m": 5e-4})
        self.assertEqual(self.sheet.get().scene.material.thickness_m, 5e-4)
        self.sheet.reset()
        self.assertEqual(self.sheet.get().scene.material.thickness_m, before)
        with self.assertRaisesRegex(ValueError, "material: .*thickness"):
            self.sheet.set_material({"thickness": 1})
        with self.assertRaises(kerf.InvalidArgument):
            self.sheet.set_material("unobtainium")

    def test_gltf(self):
        self.assertEqual(self.sheet.gltf()[:4], b"glTF")


class Asynchronous(support.AsyncCase):
    async def test_self_contact(self):
        await self.sheet.set_self_contact(True, thickness_m=0.002)
        contact = (await self.sheet.get()).scene.self_contact
        self.assertEqual((contact.mode, contact.friction, contact.thickness_m), (contact.ON, 0.3, 0.002))
        await self.sheet.reset()
        self.assertFalse((await self.sheet.get()).scene.HasField("self_contact"))

    async def test_recordings(self):
        last = await self.sheet.step(4)
        self.assertEqual(await self.sheet.record(path("aio.rec")), os.path.getsize(path("aio.rec")))
        played = await self.server.replay(path("aio.rec"), "py-aio-played", paused=True)
        self.assertEqual((await played.step(last.tick)).state_hash, last.state_hash)
        await played.delete()
