// Random cuts by the million; tests/fuzz/run_million builds and runs it.
//   many_cuts cuts COUNT STATE     COUNT cuts in all, on many sheets; what STATE says was done before is not done again
//   many_cuts sheets COUNT [ACCEPTED]  COUNT live sheets, each cut until 10,000, or ACCEPTED, cuts were accepted on it
//   many_cuts seed SEED            one trial of `cuts`
// Exit status 1 where something was wrong, which is printed with the seed of its trial.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/base/check.h"
#include "server/core/fem/model/model.h"
#include "server/core/sheet/sheet.h"
#include "tests/property/random_cut_trial.h"

namespace kerf::property {
namespace {

constexpr std::uint64_t kSinglesOfABlock = 20;  // trials of single cuts to one of a sequence: two cuts to one
constexpr int kBetweenSheetAudits = 8;          // batches
constexpr std::uint64_t kMostOfABatch = 100;    // cuts

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

// kg, compensated.
double total_mass(const fem::Model& model) {
  double sum = 0.0, rest = 0.0;
  for (const double mass : model.mass()) {
    const double value = mass - rest;
    const double next = sum + value;
    rest = (next - sum) - value;
    sum = next;
  }
  return sum;
}

struct SheetTally {
  int tried = 0, accepted = 0, missed = 0, strips = 0, audited = 0;
  std::map<std::string, int> refused;             // by reason
  double area_drift = 0.0, mass_drift = 0.0;      // -; largest seen, relative, of what there was at first
  double removed_area = 0.0, removed_mass = 0.0;  // m^2, kg; by strips
};

// A sheet that is cut as a user's is: mesh, model, state, pieces and undo follow every batch of cuts, and it falls
// meanwhile.
class LiveSheet {
 public:
  explicit LiveSheet(std::uint64_t seed) : random_(seed), sheet_(make(seed)) {
    area_ = total_area(sheet_.mesh());
    mass_ = total_mass(sheet_.model());
  }

  // A batch of cuts more, or one cut that is audited, as it comes. What is wrong in words, or nothing.
  audit::Finding cut() {
    const bool in_depth = ++batches_ % kBetweenSheetAudits == 0;
    scene::CutBatch batch;
    const std::uint64_t size = in_depth ? 1 : 1 + random_.below(kMostOfABatch);
    for (std::uint64_t i = 0; i < size; ++i) batch.cuts.push_back(any_cut());
    mesh::TriangleMesh expected = sheet_.mesh();
    if (in_depth) {
      if (audit::Finding flaw = audit_on(expected, batch.cuts.front())) return flaw;
    }
    const std::vector<scene::Command> commands{batch};
    const sheet::TickReport report = sheet_.apply(commands);
    count(report.replies.at(0), batch.cuts.size());
    if (!in_depth) return std::nullopt;
    sheet_.step({});
    ++tally_.audited;
    return check(expected);
  }

  // Checks conditions that hold after every cut, and are tested after some. `expected`: the mesh that the cuts make.
  audit::Finding check(const mesh::TriangleMesh& expected) {
    if (sheet_.mesh().state_hash() != expected.state_hash()) return "the sheet has another mesh than its cuts make";
    if (sheet_.model().hash() != fem::Model(sheet_.mesh(), sheet_.config().material).hash()) {
      return "the model is not that of the mesh";
    }
    if (!sheet_.state().x.allFinite() || sheet_.frozen()) return "the sheet has stopped moving";
    double pieces = 0.0;
    for (const scene::Piece& piece : sheet_.pieces()) pieces += piece.mass;
    const double mass = total_mass(sheet_.model());
    if (std::abs(pieces - mass) > kMostDrift * mass_) return "the pieces have not the mass of the sheet";
    tally_.area_drift =
        std::max(tally_.area_drift, std::abs(total_area(sheet_.mesh()) + tally_.removed_area - area_) / area_);
    tally_.mass_drift = std::max(tally_.mass_drift, std::abs(mass + tally_.removed_mass - mass_) / mass_);
    if (tally_.area_drift > kMostDrift) return "the area has drifted";
    if (tally_.mass_drift > kMostDrift) return "the mass has drifted";
    return std::nullopt;
  }

  [[nodiscard]] const sheet::Sheet& sheet() const { return sheet_; }
  [[nodiscard]] const SheetTally& tally() const { return tally_; }

 private:
  static constexpr double kMostDrift = 1.0e-12;  // -

  static sheet::Sheet make(std::uint64_t seed) {
    const mesh::TriangleMesh grid = test::jittered_grid(120, seed);
    scene::ArraySource arrays{Eigen::Matrix2Xd(2, grid.num_vertices()), Eigen::Matrix3Xi(3, grid.num_solid_triangles()),
                              Eigen::Matrix3Xd(3, 0), Eigen::Matrix3Xd(3, 0)};
    for (mesh::VertexId v = 0; v < grid.num_vertices(); ++v) arrays.material_positions.col(v) = grid.rest_position(v);
    Eigen::Index next = 0;
    for (const std::array<int, 3>& t : triangles_of(grid)) arrays.triangles.col(next++) << t[0], t[1], t[2];
    scene::SheetConfig config;
    config.mesh = std::move(arrays);
    config.integrator.kind = scene::IntegratorKind::kExplicitLeapfrog;
    config.integrator.max_substeps = 1;  // the motion need not keep up, it only has to be there
    Result<sheet::Sheet> made = sheet::Sheet::create(config);
    KERF_CHECK(made.ok(), "a jittered grid is a valid sheet");
    return std::move(made).value();
  }

  static audit::Finding audit_on(mesh::TriangleMesh& mesh, const scene::Cut& cut) {
    return audit::cut_and_audit(mesh, {cut.curve, cut.options, {}}, audit::kDeepest).flaw;
  }

  scene::Cut any_cut() {
    scene::Cut cut;
    cut.curve = short_curve(random_);
    cut.options.tolerance = 0.1;
    if (random_.below(8) != 0) cut.options.min_angle_deg = 5.0;
    if (random_.below(16) == 0) cut.options.width_m = std::pow(10.0, random_.uniform(-4.0, -2.5));
    return cut;
  }

  void count(const Result<scene::CommandReply>& reply, std::size_t size) {
    tally_.tried += static_cast<int>(size);
    if (!reply.ok()) {  // the whole batch is taken back
      ++tally_.refused[reply.error().reason];
      return;
    }
    for (const scene::CutReply& cut : reply->batch) {
      if (cut.status != cut::CutStatus::kApplied) {
        ++tally_.missed;
        continue;
      }
      ++tally_.accepted;
      if (cut.removed_mass) ++tally_.strips;
      tally_.removed_area += cut.report.removed_area_m2;
      tally_.removed_mass += cut.removed_mass.value_or(0.0);
    }
  }

  SeededRandom random_;
  sheet::Sheet sheet_;
  double area_ = 0.0, mass_ = 0.0;  // m^2, kg; at first
  SheetTally tally_;
  int batches_ = 0;
};

audit::Finding cut_one_sheet(std::uint64_t seed, int wanted, SheetTally& all) {
  LiveSheet live(seed);
  audit::Finding flaw;
  while (!flaw && live.tally().accepted < wanted && live.tally().tried < 2 * wanted) flaw = live.cut();
  if (!flaw) flaw = live.check(live.sheet().mesh());
  if (!flaw) flaw = audit::find_flaw(live.sheet().mesh());
  const SheetTally& t = live.tally();
  int refused = 0;
  for (const auto& [reason, count] : t.refused) {
    refused += count;
    all.refused[reason] += count;
  }
  all.tried += t.tried, all.accepted += t.accepted, all.missed += t.missed, all.strips += t.strips;
  all.audited += t.audited;
  all.area_drift = std::max(all.area_drift, t.area_drift);
  all.mass_drift = std::max(all.mass_drift, t.mass_drift);
  std::printf(
      "seed %2llu: %d accepted of %d (%d strips), %d missed, %d refused, %d pieces, %d triangles, %d vertices, drift "
      "of "
      "area %.1e, of mass %.1e\n",
      static_cast<unsigned long long>(seed), t.accepted, t.tried, t.strips, t.missed, refused,
      live.sheet().mesh().num_pieces(), live.sheet().mesh().num_solid_triangles(), live.sheet().mesh().num_vertices(),
      t.area_drift, t.mass_drift);
  std::fflush(stdout);
  if (flaw) return "cut " + std::to_string(t.tried) + ": " + *flaw;
  if (t.accepted < wanted) return "fewer cuts accepted than asked for";
  return std::nullopt;
}

int run_sheets(std::uint64_t count, int wanted) {
  int failures = 0;
  SheetTally all;
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    if (const audit::Finding flaw = cut_one_sheet(seed, wanted, all)) {
      ++failures;
      std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), flaw->c_str());
    }
  }
  std::printf("%llu sheets: %d cuts, %d accepted (%d strips), %d missed, %d audited in depth\n",
              static_cast<unsigned long long>(count), all.tried, all.accepted, all.strips, all.missed, all.audited);
  if (all.refused.empty()) std::printf("refused: none\n");
  for (const auto& [reason, number] : all.refused) {
    std::printf("refused: %d %s, %.1f in a million\n", number, reason.c_str(), 1.0e6 * number / all.tried);
  }
  std::printf("largest relative drift of area %.1e, of mass %.1e; %d failures\n", all.area_drift, all.mass_drift,
              failures);
  return failures == 0 ? 0 : 1;
}

int run(const std::string& what, const char* count, const std::string& rest) {
  if (what == "cuts" && !rest.empty()) return run_cuts(std::atoll(count), rest);
  if (what == "sheets") {
    return run_sheets(std::strtoull(count, nullptr, 10), rest.empty() ? 10'000 : std::atoi(rest.c_str()));
  }
  if (what == "seed") {
    Progress done;
    try_seed(std::strtoull(count, nullptr, 10), done);
    print(done);
    return done.failures == 0 ? 0 : 1;
  }
  std::fprintf(stderr, "say: many_cuts cuts COUNT STATE | sheets COUNT [ACCEPTED] | seed SEED\n");
  return 2;
}

}  // namespace
}  // namespace kerf::property

int main(int argc, char** argv) {
  return kerf::property::run(argc > 1 ? argv[1] : "", argc > 2 ? argv[2] : "0", argc > 3 ? argv[3] : "");
}
