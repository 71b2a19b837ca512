"""Environments with the interface of Gymnasium, without that package: the contract that its check_env holds."""

import unittest
import unittest.mock

import kerf
import kerf.env
import kerf.spaces
import numpy
import support


def resting(**holds):
    """An action that does nothing but what is given: holds, point, target, cuts, start, end."""
    action = numpy.full(11, -1.0, "f4")
    for name, place in (("holds", 0), ("point", slice(1, 3)), ("target", slice(3, 6)), ("cuts", 6), ("start", slice(7, 9)),
                        ("end", slice(9, 11))):
        if name in holds:
            action[place] = holds[name]
    return action


class Envs(unittest.TestCase):
    def setUp(self):
        self.server = kerf.connect(support.ADDRESS, timeout_s=300)
        self.addCleanup(self.server.close)

    def env(self, kind=kerf.env.SheetEnv, **options):
        env = kind(self.server, grid=(10, 10), **options)
        self.addCleanup(env.close)
        return env

    def test_the_contract_of_reset_and_step(self):
        env = self.env(max_steps=3)
        observation, info = env.reset(seed=5, options={})
        self.assertTrue(env.observation_space.contains(observation))
        self.assertEqual((info["tick"], info["pieces"]), (0, 1))
        for number in range(3):
            outcome = env.step(env.action_space.sample())
            self.assertEqual(len(outcome), 5)
            observation, reward, terminated, truncated, info = outcome
            self.assertTrue(env.observation_space.contains(observation))
            self.assertEqual((type(reward), type(terminated), type(truncated), type(info)), (float, bool, bool, dict))
            self.assertEqual((info["tick"], terminated, truncated), (4 * (number + 1), False, number == 2))

    def test_an_episode_repeats_bit_for_bit(self):
        env = self.env(max_steps=100)

        def episode():
            first, _ = env.reset(seed=3)
            env.action_space.seed(3)
            seen = [first, *(env.step(env.action_space.sample())[0] for _ in range(12))]
            return numpy.stack(seen), env.np_random.random(), env.sheet.get().state_hash

        (one, number, state_hash), (two, same, again) = episode(), episode()
        numpy.testing.assert_array_equal(one, two)
        self.assertEqual((number, state_hash), (same, again))
        self.assertGreater(numpy.abs(one[-1] - one[0]).max(), 0)

    def test_the_hand_pulls_and_lets_go(self):
        env = self.env()
        env.reset()
        for _ in range(20):
            pulled, *_ = env.step(resting(holds=1, point=(0, -0.9), target=(0, -1, 0)))
        env.reset()
        for _ in range(20):
            hanging, *_ = env.step(resting())
        middle = 2  # of the lowest row
        self.assertLess(pulled[middle, 1], hanging[middle, 1] - 0.05)
        env.step(resting(holds=1, point=(0, 0)))
        env.step(resting())
        with self.assertRaises(kerf.NotFound):
            env.sheet.drag("hand", (0, 0, 0))

    def test_a_cut_makes_pieces_and_takes_points_away(self):
        env = self.env()
        _, info = env.reset()
        observation, _, _, _, info = env.step(resting(cuts=1, start=(-1, 0.1), end=(1, 0.1)))
        self.assertEqual((info["cut"], info["pieces"]), ("applied", 2))
        self.assertTrue((observation[:, 6] == 1).all())
        _, _, _, _, info = env.step(resting(cuts=1, start=(-1, 0.1), end=(1, 0.1)))
        self.assertEqual((info["cut"], info["pieces"]), ("missed", 2))
        _, _, _, _, info = env.step(resting(cuts=1, start=(0, 0), end=(0, 0)))
        self.assertNotIn(info["cut"], ("applied", "missed"))
        env.sheet.cut(kerf.polyline((0.3, 0.1), (0.7, 0.1)), width_m=0.05)
        observation, *_ = env.step(resting())
        self.assertTrue((observation[1:4, 6] == 0).all())
        self.assertTrue((observation[observation[:, 6] == 0] == 0).all())
        _, info = env.reset()
        self.assertEqual((info["pieces"], env.sheet.get().pieces), (1, 1))

    def test_options_name_a_state_to_begin_with(self):
        env = self.env()
        env.reset()
        env.step(resting(cuts=1, start=(-1, 0.1), end=(1, 0.1)))
        env.sheet.save_state("cut")
        expected = env.sheet.state()
        env.step(resting())
        observation, info = env.reset(options={"state": "cut"})
        self.assertEqual((info["pieces"], info["tick"]), (2, expected.tick))
        self.assertEqual(env.sheet.state().state_hash, expected.state_hash)
        self.assertTrue(env.observation_space.contains(observation))
        with self.assertRaises(kerf.NotFound):
            env.reset(options={"state": "none"})

    def test_a_task_of_ones_own(self):
        class Falls(kerf.env.SheetEnv):
            def reward(self, observation, info):
                return -float(observation[:, 2].mean())

            def is_over(self, observation, info):
                return info["tick"] >= 8

        env = self.env(Falls)
        env.reset()
        _, reward, terminated, *_ = env.step(resting())
        _, later, over, truncated, _ = env.step(resting())
        self.assertEqual((terminated, over, truncated), (False, True, False))
        self.assertNotEqual(later, reward)

    def test_many_sheets_are_those_of_single_environments(self):
        class Short(kerf.env.SheetEnv):
            def is_over(self, observation, info):
                return info["pieces"] > 1

        envs = kerf.env.SheetVectorEnv(3, self.server, env_class=Short, grid=(10, 10), max_steps=4)
        self.addCleanup(envs.close)
        single = self.env(Short, max_steps=4)
        observations, info = envs.reset(seed=7)
        self.assertTrue(envs.observation_space.contains(observations))
        self.assertEqual(info["tick"].tolist(), [0, 0, 0])
        actions = numpy.stack([resting(), resting(holds=1, point=(0, 0), target=(0, -1, 0)),
                               resting(cuts=1, start=(-1, 0.1), end=(1, 0.1))])
        for number in range(4):
            observations, rewards, terminated, truncated, info = envs.step(actions)
            self.assertEqual(terminated.tolist(), [False, False, True])
            self.assertEqual(truncated.tolist(), [number == 3, number == 3, False])
        self.assertEqual((rewards.shape, info["tick"].tolist()), ((3,), [16, 16, 4]))
        first, _ = single.reset()
        for _ in range(4):
            last, *_ = single.step(actions[1])
        numpy.testing.assert_array_equal(info["final_obs"][1], last)
        numpy.testing.assert_array_equal(observations, numpy.stack([first] * 3))  # begun again
        with self.assertRaisesRegex(ValueError, "2 actions for 3 sheets"):
            envs.step(actions[:2])

    def test_wrong_actions_and_scenes(self):
        env = self.env()
        env.reset()
        for wrong in (numpy.zeros(10), numpy.full(11, numpy.nan), [1, 2]):
            with self.assertRaisesRegex(ValueError, "an action is 11 finite numbers"):
                env.step(wrong)
        with self.assertRaisesRegex(TypeError, "'grid' belongs in it"):
            kerf.env.SheetEnv(self.server, scene={"grid": {"columns": 3, "rows": 3, "width_m": 1, "height_m": 1}}, grid=(3, 3))

    def test_a_sheet_is_deleted_with_its_environment(self):
        env = kerf.env.SheetEnv(support.ADDRESS, grid=(4, 4))
        self.assertIn(env.sheet.id, [sheet.id for sheet in self.server.sheets()])
        env.close()
        self.assertNotIn(env.sheet.id, [sheet.id for sheet in self.server.sheets()])

    def test_boxes(self):
        box = kerf.spaces.Box(-1.0, 1.0, (2, 3))
        box.seed(1)
        sample = box.sample()
        self.assertIn(sample, box)
        box.seed(1)
        numpy.testing.assert_array_equal(box.sample(), sample)
        for wrong in (sample[0], sample.astype("f8"), sample + 3, [[0] * 3] * 2):
            self.assertNotIn(wrong, box)
        self.assertEqual(box, kerf.spaces.Box(-1.0, 1.0, (2, 3)))
        self.assertNotEqual(box, kerf.spaces.Box(-1.0, 2.0, (2, 3)))
        self.assertIn(kerf.spaces.Box(-numpy.inf, numpy.inf, (4,)).sample(), kerf.spaces.Box(-numpy.inf, numpy.inf, (4,)))
        self.assertEqual(repr(box), "Box(-1, 1, (2, 3), float32)")


if __name__ == "__main__":
    unittest.main()
