"""Grabs, pins, gravity and wind of a sheet, from the shell."""

import pathlib

from cli_case import Case, kerf, main, path, setUpModule, tearDownModule

HAND = (0.5, -0.3, 0.4)


class Interaction(Case):
    def sheet(self, name):
        self.json_of("sheet", "create", name, "--grid", "6x6", "--pin", "none", "--paused")
        return name

    def positions(self, name):
        out = path(f"{name}.obj")
        self.assertEqual(kerf("export", name, "--out", out).returncode, 0)
        lines = pathlib.Path(out).read_text().splitlines()
        return [tuple(map(float, line.split()[1:])) for line in lines if line.startswith("v ")]

    def stepped(self, name, ticks):
        self.json_of("sheet", "step", name, str(ticks))
        return self.positions(name)

    def test_a_grab_pulls_is_dragged_and_lets_go(self):
        name = self.sheet("pulled")
        self.json_of("sheet", "gravity", name, "0,0,0")
        done = kerf("sheet", "grab", name, "hand", "--vertex", "7", "--to", ",".join(map(str, HAND)))
        self.assertEqual((done.returncode, done.stdout), (0, "set at tick 0\n"))
        start = self.positions(name)[7]
        near = self.stepped(name, 120)[7]
        away = lambda point, target: sum((a - b) ** 2 for a, b in zip(point, target)) ** 0.5
        self.assertLess(away(near, HAND), 0.3 * away(start, HAND))
        self.assertEqual(self.json_of("sheet", "drag", name, "hand", "-1,0,0"), {"tick": 120})
        self.assertLess(away(self.stepped(name, 120)[7], (-1, 0, 0)), 0.3 * away(near, (-1, 0, 0)))
        self.json_of("sheet", "release", name, "hand")
        self.refused("sheet", "release", name, "hand", says="GRAB_NOT_FOUND")
        self.refused("sheet", "drag", name, "hand", "0,0", code=2, says="x,y,z")
        self.refused("sheet", "grab", name, "hand", code=2)
        self.refused("sheet", "grab", name, "hand", "--at", "0,0", "--vertex", "1", code=2)
        self.refused("sheet", "grab", name, "hand", "--at", "0,0 1,1", code=2, says="one point")
        self.refused("sheet", "grab", name, "hand", "--vertex", "999", says="grab.vertex")

    def test_pins_gravity_and_wind(self):
        name = self.sheet("held")
        self.json_of("sheet", "gravity", name, "0,0,-2")
        self.json_of("sheet", "pins", name, "left", "1,0")
        start, then = self.positions(name), self.stepped(name, 30)
        held = [i for i, (before, after) in enumerate(zip(start, then)) if before == after]
        self.assertEqual(held, [0, 5, 6, 12, 18, 24, 30], "the left edge and the corner at (1, 0)")
        self.json_of("sheet", "pins", name, "none")
        self.json_of("sheet", "wind", name, "none")
        fallen = self.stepped(name, 30)
        self.assertTrue(all(after[2] < before[2] for before, after in zip(then, fallen)))
        self.json_of("sheet", "gravity", name, "0,0,0")
        still = self.stepped(name, 1)
        self.json_of("sheet", "wind", name, "0,30,0", "--density", "10")
        blown = self.stepped(name, 60)
        drift = sum(after[1] - before[1] for before, after in zip(still, blown)) / len(still)
        self.assertGreater(drift, 0.05)
        self.refused("sheet", "pins", name, "middle", code=2, says="top, bottom")
        self.refused("sheet", "pins", name, "5,5,6,6", says="REGION_EMPTY")
        self.refused("sheet", "pins", name, "none", "left", code=2, says="PLACE")
        self.refused("sheet", "gravity", name, "down", code=2, says="x,y,z")
        self.refused("sheet", "gravity", name, "0,0,1e9", says="gravity")
        self.refused("sheet", "wind", name, "0,1e9,0", says="velocity")
        self.refused("sheet", "wind", "nobody", "none", says="nobody")


if __name__ == "__main__":
    main(__doc__)
