// Random cuts by the million; tests/fuzz/run_million builds and runs it.
//   many_cuts cuts COUNT STATE     COUNT cuts in all, on many sheets; what STATE says was done before is not done again
//   many_cuts sheets COUNT         COUNT sheets, each cut until 10,000 cuts were accepted on it
//   many_cuts seed SEED            one trial of `cuts`
// Exit status 1 where something was wrong, which is printed with the seed of its trial.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/property/random_cut_trial.h"

namespace kerf::property {
namespace {

constexpr std::uint64_t kSinglesOfABlock = 20;  // trials of single cuts to one of a sequence: two cuts to one
constexpr int kAcceptedCuts = 10'000;
constexpr int kBetweenAudits = 250;

struct Progress {
  std::uint64_t next_block = 0;
  std::int64_t failures = 0;
  double seconds = 0.0;
  Tally tally;
};

long long wide(std::int64_t count) {
  return static_cast<long long>(count);
}

void print(const Progress& done) {
  const Tally& t = done.tally;
  std::int64_t refused = 0;
  for (const auto& [reason, count] : t.refused) refused += count;
  std::printf("%-34s %12lld\n%-34s %12lld\n%-34s %12lld\n%-34s %12lld\n%-34s %12lld\n", "cuts", wide(t.cuts), "applied",
              wide(t.applied), "missed or retraced", wide(t.missed), "not a curve (a point)", wide(t.invalid),
              "refused", wide(refused));
  for (const auto& [reason, count] : t.refused) std::printf("  %-32s %12lld\n", reason.c_str(), wide(count));
  std::printf("%-34s %12lld\n%-34s %12lld\n%-34s %12lld\n%-34s %12.1e\n%-34s %12.0f\n",
              "refinement stopped by its guard", wide(t.stopped), "undone, reread and sampled", wide(t.deep),
              "INVARIANT FAILURES", wide(done.failures), "largest relative drift of area", t.area_drift, "seconds",
              done.seconds);
}

Progress load(const std::string& file) {
  Progress done;
  std::ifstream in(file);
  if (!in) return done;
  Tally& t = done.tally;
  in >> done.next_block >> done.failures >> done.seconds >> t.cuts >> t.applied >> t.missed >> t.invalid >> t.stopped >>
      t.deep >> t.area_drift;
  std::string reason;
  for (std::int64_t count = 0; in >> reason >> count;) t.refused[reason] = count;
  return done;
}

void save(const std::string& file, const Progress& done) {
  const Tally& t = done.tally;
  std::ofstream out(file + ".new");
  out << done.next_block << ' ' << done.failures << ' ' << done.seconds << ' ' << t.cuts << ' ' << t.applied << ' '
      << t.missed << ' ' << t.invalid << ' ' << t.stopped << ' ' << t.deep << ' ' << t.area_drift << '\n';
  for (const auto& [reason, count] : t.refused) out << reason << ' ' << count << '\n';
  out.close();
  std::rename((file + ".new").c_str(), file.c_str());
}

void try_seed(std::uint64_t seed, Progress& done) {
  const std::map<std::string, std::int64_t> refused_before = done.tally.refused;
  if (const audit::Finding flaw = run_trial(seed, done.tally)) {
    ++done.failures;
    std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), flaw->c_str());
  }
  if (done.tally.refused != refused_before) {
    std::printf("seed %llu: a cut was refused\n", static_cast<unsigned long long>(seed));
  }
}

int run_cuts(std::int64_t count, const std::string& state) {
  Progress done = load(state);
  auto last_shown = std::chrono::steady_clock::now();
  while (done.tally.cuts < count) {
    const auto started = std::chrono::steady_clock::now();
    const std::uint64_t block = done.next_block++;
    for (std::uint64_t i = 0; i < kSinglesOfABlock; ++i) try_seed(2 + 2 * (kSinglesOfABlock * block + i), done);
    try_seed(2 * block + 1, done);
    const auto now = std::chrono::steady_clock::now();
    done.seconds += std::chrono::duration<double>(now - started).count();
    save(state, done);
    if (now - last_shown < std::chrono::seconds(60)) continue;
    last_shown = now;
    std::printf("... %lld of %lld cuts, %lld failures, %.0f s\n", wide(done.tally.cuts), wide(count),
                wide(done.failures), done.seconds);
    std::fflush(stdout);
  }
  print(done);
  return done.failures == 0 ? 0 : 1;
}

// Short cuts all over a sheet of 120 x 120 vertices, across each other and over older ones.
cut::Curve short_curve(SeededRandom& random) {
  const Eigen::Vector2d at = random_point(random, 0.01);
  const double size = std::pow(10.0, random.uniform(-3.5, -1.5));
  switch (random.below(4)) {
    case 0:
      return cut::Circle{at, 0.5 * size};
    case 1:
      return cut::Polyline{{at, at + polar(random.uniform(0.0, 6.28), 2.0 * size)}};
    default: {
      cut::CubicBezier bezier{{at}};
      for (int i = 0; i < 3; ++i)
        bezier.points.push_back(bezier.points.back() + polar(random.uniform(0.0, 6.28), size));
      return bezier;
    }
  }
}

audit::Finding cut_one_sheet(std::uint64_t seed) {
  SeededRandom random(seed);
  mesh::TriangleMesh mesh = test::jittered_grid(120, seed);
  const double area = total_area(mesh);
  int accepted = 0, tried = 0, refused = 0;
  double drift = 0.0;
  while (accepted < kAcceptedCuts && tried < 2 * kAcceptedCuts) {
    cut::CutRequest request{short_curve(random), {}, {}};
    request.options.tolerance = 0.1;
    if (random.below(8) != 0) request.options.min_angle_deg = 0.0;
    ++tried;
    if (tried % kBetweenAudits == 0) {
      const audit::AuditedCut done = audit::cut_and_audit(mesh, request, audit::kDeepest);
      if (done.flaw) return "cut " + std::to_string(tried) + ": " + *done.flaw;
      if (done.end == audit::AuditedCut::End::kApplied) ++accepted;
      drift = std::max(drift, std::abs(total_area(mesh) - area) / area);
      continue;
    }
    const Result<cut::CutPlan> plan = cut::plan(mesh, request);
    if (!plan.ok()) return "cut " + std::to_string(tried) + ": " + plan.error().message;
    const Result<cut::CutOutcome> done = cut::apply(mesh, *plan);
    if (!done.ok()) {
      ++refused;
    } else if (done->status == cut::CutStatus::kApplied) {
      ++accepted;
    }
  }
  drift = std::max(drift, std::abs(total_area(mesh) - area) / area);
  std::printf("seed %2llu: %d accepted of %d, %d refused, %d pieces, %d triangles, %d vertices, area drift %.1e\n",
              static_cast<unsigned long long>(seed), accepted, tried, refused, mesh.num_pieces(),
              mesh.num_solid_triangles(), mesh.num_vertices(), drift);
  std::fflush(stdout);
  if (audit::Finding flaw = audit::find_flaw(mesh)) return flaw;
  if (accepted < kAcceptedCuts) return "fewer cuts accepted than asked for";
  if (drift > 1e-12) return "the area has drifted";
  return std::nullopt;
}

int run_sheets(std::uint64_t count) {
  int failures = 0;
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    if (const audit::Finding flaw = cut_one_sheet(seed)) {
      ++failures;
      std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), flaw->c_str());
    }
  }
  std::printf("%llu sheets, %d failures\n", static_cast<unsigned long long>(count), failures);
  return failures == 0 ? 0 : 1;
}

int run(const std::string& what, const char* count, const std::string& state) {
  if (what == "cuts" && !state.empty()) return run_cuts(std::atoll(count), state);
  if (what == "sheets") return run_sheets(std::strtoull(count, nullptr, 10));
  if (what == "seed") {
    Progress done;
    try_seed(std::strtoull(count, nullptr, 10), done);
    print(done);
    return done.failures == 0 ? 0 : 1;
  }
  std::fprintf(stderr, "say: many_cuts cuts COUNT STATE | sheets COUNT | seed SEED\n");
  return 2;
}

}  // namespace
}  // namespace kerf::property

int main(int argc, char** argv) {
  return kerf::property::run(argc > 1 ? argv[1] : "", argc > 2 ? argv[2] : "0", argc > 3 ? argv[3] : "");
}
