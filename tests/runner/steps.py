"""The steps of deploy/test: what each proves, its commands, and the seconds that it takes on two cores from nothing."""

import dataclasses
import pathlib
import random

ROOT = pathlib.Path(__file__).resolve().parents[2]
RUNNER = "/usr/bin/python3 tests/runner"


@dataclasses.dataclass(frozen=True)
class Step:
    name: str
    proves: str
    commands: tuple  # of bash, run from the root of the repository; the first that fails ends the step
    seconds: float  # on two cores, from nothing; a first guess of the time left
    needs: tuple = ()  # steps that run before it; where one fails, this one is not run
    preset: str = ""  # of ctest, where the step runs it: which tests failed is read from its report
    environment: str = ""  # that its tests have, to be said before a command that runs one of them alone
    beside: tuple = ()  # steps that run at the same time, where a processor would be idle in either


def build(preset, options="", targets=""):
    """Reports every error of the compiler, not the first alone."""
    return (f"cmake --preset {preset} {options} >/dev/null", f"cmake --build --preset {preset} {targets} -- -k 0")


def ctest(preset, arguments=""):
    """The tests of a build that has just been made: the fixture that builds it is left out."""
    return f'ctest --preset {preset} --fixture-exclude-setup built --output-junit "$LOG.xml" {arguments}'


SEED = random.SystemRandom().randrange(1, 1_000_000)
TRIALS = f"KERF_TRIALS=many KERF_SEED={SEED}"

STEPS = {step.name: step for step in (
    Step("format", "sources are formatted, and nothing else lies at the top level",
         ("tests/runner/check_format",), 6),
    Step("build", "everything compiles without a warning, as it ships (the build of deploy/run, with its tests)",
         build("release", "-DKERF_TESTS=ON -DKERF_BENCH=OFF -DKERF_FAULTS=OFF"), 500),
    Step("tests", "units, accuracy against references, properties of random cuts, API, clients, the lines of the pages",
         ("nice -n 5 " + ctest("release"),),  # gives way to the browser, whose steps wait for one another
         210, ("build",), "release"),
    Step("units", "all of that but what takes long: random trials, accuracy, programs run from outside",
         (ctest("quick"),), 70, ("build",), "quick"),
    Step("benchmarks", "benchmarks compile, and compute what they did, by the hashes of their results",
         (*build("release", "-DKERF_BENCH=ON", "--target benches many_cuts"),
          "build/release/bin/kerf_bench --benchmark_min_time=0.01 "
          "--benchmark_filter='/(225|2500)(/|$)|random_cuts/(0|10|50)/demo'"), 135, ("build",)),
    Step("viewer", "the browser viewer's types and units, and that it builds",
         ("deploy/build-viewer", "cd web && npx vitest run"), 40, beside=("build",)),
    Step("browser", "the viewer in a real browser against a real kerfd",
         ("tests/e2e/run build/release/bin/kerfd",), 200, ("build", "viewer"),
         beside=("tests",)),
    Step("core", "the simulation library builds without any network package",
         (*build("core"), ctest("core", "-R 'golden|include_table'")), 60, ("build",), "core"),
    Step("faults", "the audit of random cuts catches each of 60 faults that are built into a copy of the cutter",
         (*build("release", "-DKERF_FAULTS=ON", "--target faults_tests"), ctest("release", "-R '^faults_tests_'")), 90,
         ("build",), "release"),
    Step("each-file", f"a second compiler (clang) takes an eighth of the sources ({SEED}) one by one, as editors do",
         (f"{RUNNER}/each_file.py {SEED}",), 100),
    Step("asan", "no test makes the libraries touch memory that is not theirs, or do what C++ leaves undefined; every mesh "
         "invariant holds after every edit",
         (*build("asan"), ctest("asan")), 720, ("build",), "asan", "KERF_TRIALS=few"),
    Step("tsan", "no two threads of the host, the streams and the API race",
         (*build("tsan"), ctest("tsan")), 260, (), "tsan", "KERF_TRIALS=few"),
    Step("fuzz", "arbitrary bytes in requests, meshes, recordings and cuts break nothing; clang's build has the same hashes",
         ("tests/fuzz/run_fuzzers 1500", "cmake --build build/fuzz --target golden_test",
          "build/fuzz/bin/golden_test --gtest_filter='*HashesAreThoseWrittenDown'"), 300),
    Step("trials", f"random cuts and undos from a seed that is new each time ({SEED}), and more of the stability matrix",
         (f"echo 'the same again: {TRIALS} ctest --preset release -L trials'", f"{TRIALS} {ctest('release', '-L trials')}"),
         240, ("build",), "release", TRIALS),
    Step("matrix", "a third of the stability matrix with all of its steps, and a share of that of sheets that touch themselves",
         ("build/release/bin/stability_matrix 16 600", "build/release/bin/stability_touching 2 40"), 130, ("build",)),
)}

SETS = {
    "": ("format", "build", "viewer", "tests", "browser"),
    "quick": ("format", "build", "viewer", "units"),
    "deep": ("build", "benchmarks", "core", "faults", "each-file", "asan", "tsan", "fuzz", "trials", "matrix"),
}


def with_needs(names):
    """The steps by name, each after those that it needs, none twice."""
    ordered = []

    def add(name):
        for needed in STEPS[name].needs:
            add(needed)
        if name not in ordered:
            ordered.append(name)

    for name in names:
        add(name)
    return [STEPS[name] for name in ordered]


@dataclasses.dataclass(frozen=True)
class Proof:
    """One that is run by name, most of an hour or more; tests/long/NAME.md holds its last result."""
    proves: str
    command: str
    takes: str


LONG = {
    "cuts": Proof("a million random cuts, each audited, in a build that checks every mesh invariant after every edit",
                  "tests/fuzz/run_million", "an hour on one core"),
    "live-sheets": Proof("10,000 accepted cuts on each of 20 live sheets: nothing is lost, area and mass do not drift",
                         "tests/fuzz/run_million sheets", "some hours"),
    "matrix": Proof("all 1,008 cases of the stability matrix, 600 steps each, and 180 of sheets that touch themselves",
                    "cmake --preset release >/dev/null; "
                    "cmake --build --preset release --target stability_matrix stability_touching >/dev/null; status=0; "
                    "build/release/bin/stability_matrix || status=1; build/release/bin/stability_touching || status=1; "
                    "exit $status",
                    "10 minutes on one core"),
    "ten-thousand-cuts": Proof(
        "a hanging sheet that is cut 10,000 times continues without a failed step",
        "cmake --preset release >/dev/null; cmake --build --preset release --target stability_cuts >/dev/null; "
        "build/release/bin/stability_cuts 10000 200 10",
        "2 minutes on one core"),
    "folds": Proof(
        "1,000 sheets with self-contact fall on a floor after 12 random cuts each: in no tick does a triangle pass through "
        "another, or the energy grow by more than 1e-5 of it",
        "cmake --preset release >/dev/null; cmake --build --preset release --target property_tests >/dev/null; status=0; "
        "for seed in $(shuf -i 1000000-9999999 -n 25); do echo \"KERF_SEED=$seed: 40 sheets\"; "
        "KERF_TRIALS=many KERF_SEED=$seed build/release/bin/property_tests --gtest_brief=1 "
        "--gtest_filter='SelfContactCuts.ASheetThatFalls*' || status=1; done; exit $status", "8 minutes on one core"),
    "power": Proof(
        "102,900 losses of power while a store works, each before another operation of its disk: no change that was answered is "
        "lost, doubled or changed, and the store is whole",
        "cmake --preset release >/dev/null; cmake --build --preset release --target store_tests >/dev/null; "
        "shuf -i 1000000-9999999 -n 49 | xargs -P 2 -I SEED sh -c 'echo \"KERF_SEED=SEED: 700 trials of three losses\"; "
        "KERF_TRIALS=usual KERF_SEED=SEED build/release/bin/store_tests --gtest_brief=1 --gtest_filter=Power.Nothing*'",
        "5 minutes on two cores"),
    "kills": Proof(
        "a kerfd under load is killed 1,000 times: every answered change is there once, with its answer, and no sheet differs",
        "cmake --preset release >/dev/null; cmake --build --preset release --target kerfd >/dev/null; status=0; "
        "for seed in $(shuf -i 1000000-9999999 -n 20); do echo \"seed $seed\"; "
        "tests/durable/kills.py build/release/bin/kerfd --kills 50 --seed $seed || status=1; done; exit $status",
        "10 minutes on two cores"),
    "package": Proof(
        "the Debian package installs in a Debian 12 that has nothing else, starts as its service would, keeps its sheets, and leaves "
        "nothing behind when purged",
        "deploy/setup build; deploy/build-viewer; cmake --preset release >/dev/null; "
        "cmake --build --preset release --target installed >/dev/null; (cd build/release && cpack -G DEB >/dev/null); "
        "tests/install/clean_root build/release/kerf_*.deb", "5 minutes; needs root, mmdebstrap and Debian's archive"),
    "each-file": Proof("a second compiler (clang) takes every source by itself, as editors do",
                       f"{RUNNER}/each_file.py", "12 minutes on two cores"),
    "attacks": Proof("seventeen kinds of attack change no tick of nine sheets beside them, nor their pace; kerfd keeps its memory, "
                     "answers and ends in order",
                     "cmake --preset release >/dev/null; cmake --build --preset release --target kerfd kerf >/dev/null; "
                     "tests/abuse/attacks.py build/release/bin/kerfd build/release/bin/kerf", "8 minutes on two cores"),
    "proxy": Proof("ten kinds of attack through HAProxy with deploy/haproxy.cfg let kerfd's memory grow by no more than 16 MiB, and "
                   "change no bit of the sheets beside them",
                   "cmake --preset release >/dev/null; cmake --build --preset release --target kerfd kerf >/dev/null; "
                   "tests/abuse/proxy.py --kerfd build/release/bin/kerfd --seconds 60", "15 minutes on two cores"),
    "fuzz": Proof("an hour of each fuzzer, on top of what earlier runs found",
                  "tests/fuzz/run_fuzzers 0", "four hours"),
    "trials": Proof("random trials from a new seed, as in `deploy/test deep`, ten seeds long",
                    "cmake --preset release >/dev/null; cmake --build --preset release >/dev/null; "
                    "for seed in $(shuf -i 1000000-9999999 -n 10); do echo KERF_SEED=$seed; "
                    "KERF_TRIALS=many KERF_SEED=$seed ctest --preset release -L trials || exit 1; done", "40 minutes"),
}
