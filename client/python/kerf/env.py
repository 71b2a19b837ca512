"""Sheets for reinforcement learning, with the interface of Gymnasium's environments. It works without that package.

    import kerf.env

    env = kerf.env.SheetEnv("127.0.0.1:50051", grid=(20, 20))
    observation, info = env.reset(seed=1)
    for _ in range(100):
        observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
        if terminated or truncated:
            observation, info = env.reset()
    env.close()

Override reward() and is_over() for a task of your own. SheetVectorEnv steps many sheets in one call.
"""

from __future__ import annotations

import secrets
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple, Union

import kerf
from kerf.arrays import numpy_module
from kerf.blocking.client import Server, connect
from kerf.blocking.sheet import Sheet
from kerf.curves import polyline
from kerf.cuts import APPLIED
from kerf.errors import Error, NotFound
from kerf.images import decode_image
from kerf.probes import probe
from kerf.scenes import AnyScene, SheetOptions, as_scene, scene_with
from kerf.spaces import make_box
from kerf.steps import Stepped
from kerf.v1 import analysis_pb2

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from kerf.arrays import Float32s

try:
    from gymnasium import Env as _Env
except ImportError:
    _Env = object

_START = "start"  # name of the saved state with which an episode begins
_HAND = "hand"  # name of the grab
_HOLDS, _POINT, _TARGET, _CUTS, _FROM, _TO = 0, slice(1, 3), slice(3, 6), 6, slice(7, 9), slice(9, 11)
_NUM_ACTIONS = 11


class _Episode:
    """One sheet with its hand; the part that SheetEnv and SheetVectorEnv share."""

    def __init__(self, server: Server, scene: Any, per_side: int, reach_m: float) -> None:
        self.server = server
        self.sheet: Sheet = server.create_scene(scene, f"env-{secrets.token_hex(6)}", paused=True)
        self.reach_m = reach_m
        box = _material_box(self.sheet)
        self.low, self.size = box
        self.probes = _probes(self.low, self.size, per_side)
        self.num_points = per_side * per_side
        self.sheet.save_state(_START)
        self.holds = False
        self.start = self.observed(self.sheet.measure(self.probes).array)
        self.num_steps = 0
        self.pieces = 1

    def reset(self, state: str) -> Dict[str, Any]:
        status = self.sheet.restore_state(state)  # without the hand
        self.holds = False
        self.num_steps = 0
        self.pieces = status.pieces
        return {"tick": status.tick, "pieces": status.pieces}

    def act(self, action: Float32s) -> Dict[str, Any]:
        """Moves the hand and cuts, as the action says; returns what became of the cut."""
        info: Dict[str, Any] = {}
        if action[_CUTS] > 0:
            ends = [self._material(action[each]) for each in (_FROM, _TO)]
            try:
                result = self.sheet.cut(polyline(*ends))
                info["cut"] = "applied" if result.status == APPLIED else "missed"
                self.pieces = result.pieces if result.status == APPLIED else self.pieces
            except Error as refused:
                info["cut"] = refused.reason
        if action[_HOLDS] > 0:
            self._hold(action)
        elif self.holds:
            self._let_go()
        return info

    def observed(self, values: Any) -> Float32s:
        """Returns the values of the probes as points x (position, velocity, exists)."""
        numpy = numpy_module()
        rows = numpy.concatenate([values.reshape(2, self.num_points, 3)[0], values.reshape(2, self.num_points, 3)[1]], axis=1)
        exists = numpy.isfinite(rows).all(axis=1, keepdims=True)
        return numpy.concatenate([numpy.where(exists, rows, 0.0), exists], axis=1).astype("f4")

    def delete(self) -> None:
        try:
            self.sheet.delete()
        except NotFound:
            pass

    def _material(self, share: Float32s) -> Tuple[float, float]:
        """Converts numbers in -1..1 to material coordinates, metres."""
        x, y = self.low + (share + 1) / 2 * self.size
        return float(x), float(y)

    def _hold(self, action: Float32s) -> None:
        target = action[_TARGET] * self.reach_m + self.start[:, :3].mean(axis=0)
        try:
            if self.holds:
                self.sheet.drag(_HAND, target)
            else:
                self.sheet.grab(_HAND, self._material(action[_POINT]), target)
                self.holds = True
        except Error:  # nothing is there to hold, or a cut took it away
            self.holds = False

    def _let_go(self) -> None:
        self.holds = False
        try:
            self.sheet.release(_HAND)
        except NotFound:
            pass


class SheetEnv(_Env):  # type: ignore[misc]
    """A sheet that an agent pulls and cuts. One step is some ticks of the sheet.

    An action is 11 numbers in -1..1. The first one holds the sheet if it is above 0, and lets go otherwise. The next two
    are the point to grab, in material coordinates from one side of the sheet to the other. They count when the hand
    closes. The next three are where the hand is, from the middle of the sheet at the start, in units of `reach_m`. The
    seventh cuts if it is above 0, from the point of the next two numbers to that of the last two.

    An observation has a row for each of `per_side` x `per_side` points of the sheet: position (m), velocity (m/s), and 1
    if the point exists, 0 if its material is gone. `info` has the tick, the number of pieces, and "cut" if one was tried:
    "applied", "missed" or the reason of a refusal.

    >>> env = SheetEnv(server, grid=(8, 8))
    >>> observation, info = env.reset(seed=1)
    >>> observation.shape, info["tick"]
    ((25, 7), 0)
    >>> observation, reward, terminated, truncated, info = env.step(numpy.zeros(11))
    >>> reward, terminated, truncated, info["tick"]
    (0.0, False, False, 4)
    >>> env.close()
    """

    metadata: Dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 15}

    def __init__(
        self,
        server: Union[kerf.Server, str] = "127.0.0.1:50051",
        *,
        scene: Optional[AnyScene] = None,
        ticks_per_step: int = 4,
        max_steps: int = 250,
        per_side: int = 5,
        reach_m: float = 0.5,
        render_mode: Optional[str] = None,
        **options: Unpack[SheetOptions],
    ) -> None:
        """server: a connection or an address. scene: as in Server.create_scene(); absent: the options are as in
        Server.create_sheet(). ticks_per_step: 1..100000. max_steps: steps after which an episode is truncated.
        render_mode: "rgb_array" or None. Raises as create_sheet() does."""
        self.server, self._owns_server = _server(server)
        self.ticks_per_step, self.max_steps, self.render_mode = ticks_per_step, max_steps, render_mode
        self._episode = _Episode(self.server, _scene(scene, options), per_side, reach_m)
        self.action_space = make_box(-1.0, 1.0, (_NUM_ACTIONS,))
        self.observation_space = make_box(-float("inf"), float("inf"), self._episode.start.shape)

    @property
    def sheet(self) -> kerf.Sheet:
        """The sheet, to look at, or to save further states of."""
        return self._episode.sheet

    def reward(self, observation: Float32s, info: Mapping[str, Any]) -> float:
        """Returns the reward of a step that ended so. Override it; here it is 0."""
        return 0.0

    def is_over(self, observation: Float32s, info: Mapping[str, Any]) -> bool:
        """Returns True if the task is done or lost. Override it; here it never is."""
        return False

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[Mapping[str, Any]] = None
    ) -> Tuple[Float32s, Dict[str, Any]]:
        """Brings the sheet back to the start, or to the saved state named by options["state"], bit for bit and with its
        tick. seed: begins `np_random` again."""
        _begin_random(self, seed)
        state = (options or {}).get("state", _START)
        info = self._episode.reset(state)
        if state == _START:
            return self._episode.start.copy(), info
        return self._episode.observed(self.sheet.measure(self._episode.probes).array), info

    def step(self, action: Any) -> Tuple[Float32s, float, bool, bool, Dict[str, Any]]:
        """Acts, runs the ticks, and returns observation, reward, terminated, truncated and info. A sheet for which no
        finite step is found ends the episode; info["failure"] says so."""
        episode = self._episode
        info = episode.act(_checked(action))
        (stepped,) = self.server.step([episode.sheet], self.ticks_per_step, probes=episode.probes)
        return _outcome(self, episode, stepped, info)

    def render(self) -> Any:
        """Returns a picture as height x width x 3 uint8 if `render_mode` is "rgb_array", else None."""
        if self.render_mode != "rgb_array":
            return None
        return decode_image(self.sheet.render((480, 360)))

    def close(self) -> None:
        """Deletes the sheet, and closes the connection that the environment opened."""
        self._episode.delete()
        if self._owns_server:
            self.server.close()


class SheetVectorEnv:
    """Many sheets that are stepped side by side, in one call of the server. Actions and observations are those of SheetEnv,
    one after another. An episode that ends begins again in the same step: its last observation is in
    info["final_obs"][i].

    env_class: SheetEnv or a subclass, whose reward() and is_over() count.

    >>> envs = SheetVectorEnv(3, server, grid=(8, 8))
    >>> observations, info = envs.reset(seed=1)
    >>> observations, rewards, terminated, truncated, info = envs.step(numpy.zeros((3, 11)))
    >>> observations.shape, rewards.tolist(), info["tick"].tolist()
    ((3, 25, 7), [0.0, 0.0, 0.0], [4, 4, 4])
    >>> envs.close()
    """

    metadata: Dict[str, Any] = {"autoreset_mode": "SameStep"}

    def __init__(
        self, num_envs: int, server: Union[kerf.Server, str] = "127.0.0.1:50051", *, env_class: Any = SheetEnv, **options: Any
    ) -> None:
        """num_envs: 1..256. options: those of SheetEnv."""
        self.server, self._owns_server = _server(server)
        self.num_envs = num_envs
        self.envs: List[SheetEnv] = []
        for _ in range(num_envs):
            self.envs.append(env_class(self.server, **options))
        self.single_action_space = self.envs[0].action_space
        self.single_observation_space = self.envs[0].observation_space
        self.action_space = make_box(-1.0, 1.0, (num_envs, _NUM_ACTIONS))
        shape = (num_envs, *self.single_observation_space.shape)
        self.observation_space = make_box(-float("inf"), float("inf"), shape)

    def reset(
        self, *, seed: Union[int, Sequence[Optional[int]], None] = None, options: Optional[Mapping[str, Any]] = None
    ) -> Tuple[Float32s, Dict[str, Any]]:
        """Resets all. seed: one for each, or a number from which they are counted."""
        numpy = numpy_module()
        seeds: Sequence[Optional[int]]
        if seed is None:
            seeds = [None] * self.num_envs
        else:
            seeds = [seed + number for number in range(self.num_envs)] if isinstance(seed, int) else seed
        begun = [env.reset(seed=each, options=options) for env, each in zip(self.envs, seeds)]
        return numpy.stack([observation for observation, _ in begun]), _stacked([info for _, info in begun])

    def step(self, actions: Any) -> Tuple[Float32s, Any, Any, Any, Dict[str, Any]]:
        """Returns arrays of observations, rewards, terminated and truncated, and infos of arrays."""
        numpy = numpy_module()
        episodes = [env._episode for env in self.envs]
        if len(actions) != self.num_envs:
            raise ValueError(f"there are {len(actions)} actions for {self.num_envs} sheets")
        infos = [episode.act(_checked(action)) for episode, action in zip(episodes, actions)]
        first = self.envs[0]
        stepped = self.server.step(
            [episode.sheet for episode in episodes], first.ticks_per_step, probes=episodes[0].probes
        )
        outcomes = [_outcome(*each) for each in zip(self.envs, episodes, stepped, infos)]
        observations = [outcome[0] for outcome in outcomes]
        final: List[Any] = [None] * self.num_envs
        for number, (observation, _, terminated, truncated, _) in enumerate(outcomes):
            if terminated or truncated:
                final[number] = observation
                observations[number], _ = self.envs[number].reset()
        info = _stacked([outcome[4] for outcome in outcomes])
        if any(each is not None for each in final):
            info["final_obs"] = final
        rewards, over, cut_short = (numpy.array([outcome[k] for outcome in outcomes]) for k in (1, 2, 3))
        return numpy.stack(observations), rewards, over, cut_short, info

    def close(self) -> None:
        """Deletes the sheets, and closes the connection that was opened for them."""
        for env in self.envs:
            env.close()
        if self._owns_server:
            self.server.close()


def _outcome(
    env: SheetEnv, episode: _Episode, stepped: Stepped, info: Dict[str, Any]
) -> Tuple[Float32s, float, bool, bool, Dict[str, Any]]:
    assert stepped.probes is not None
    episode.num_steps += 1
    observation = episode.observed(stepped.probes.array)
    info.update(tick=stepped.tick, pieces=episode.pieces)
    if stepped.failure:
        info["failure"] = stepped.failure
    terminated = bool(stepped.failure) or bool(env.is_over(observation, info))
    truncated = not terminated and episode.num_steps >= env.max_steps
    return observation, float(env.reward(observation, info)), terminated, truncated, info


def _server(server: Union[Server, str]) -> Tuple[Server, bool]:
    return (connect(server), True) if isinstance(server, str) else (server, False)


def _scene(scene: Optional[AnyScene], options: SheetOptions) -> Any:
    if scene is not None and options:
        raise TypeError(f"a scene is given: {min(options)!r} belongs in it")
    return scene_with(options) if scene is None else as_scene(scene)


def _begin_random(env: Any, seed: Optional[int]) -> None:
    """Seeds np_random as Gymnasium's Env.reset() does."""
    if _Env is not object:
        super(SheetEnv, env).reset(seed=seed)
    elif seed is not None or not hasattr(env, "np_random"):
        env.np_random = numpy_module().random.default_rng(seed)


def _checked(action: Any) -> Float32s:
    array = numpy_module().asarray(action, dtype="f4")
    if array.shape != (_NUM_ACTIONS,) or not numpy_module().isfinite(array).all():
        raise ValueError(f"an action is {_NUM_ACTIONS} finite numbers, not {action!r:.200}")
    return numpy_module().clip(array, -1.0, 1.0)


def _material_box(sheet: Sheet) -> Tuple[Any, Any]:
    """Returns the lower corner and the size of the sheet in material coordinates, metres."""
    material = sheet.state().material_positions
    low = material.min(axis=0)
    return low, material.max(axis=0) - low


def _probes(low: Any, size: Any, per_side: int) -> List[analysis_pb2.Probe]:
    """Returns probes of positions and velocities at points that cover the sheet."""
    shares = [(number + 0.5) / per_side for number in range(per_side)]
    points = [low + size * (x, y) for y in shares for x in shares]
    return [probe("position", "position", points=points), probe("velocity", "velocity", points=points)]


def _stacked(infos: List[Dict[str, Any]]) -> Dict[str, Any]:
    """Returns the numbers of all infos as arrays, and all else as lists with None where there is nothing."""
    numpy = numpy_module()
    keys = {key for info in infos for key in info}
    lists = {key: [info.get(key) for info in infos] for key in sorted(keys)}
    return {key: numpy.array(each) if None not in each and key != "cut" else each for key, each in lists.items()}
