#include "tests/audit/cut_audit.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/audit/old_mesh_index.h"
#include "tests/audit/path_audit.h"
#include "tests/audit/shape_audit.h"
#include "tests/audit/source_audit.h"
#include "tests/audit/strip_audit.h"

namespace kerf::audit {
namespace {

using Box = Eigen::AlignedBox2d;
using Eigen::Vector2d;
using mesh::kNone;
using mesh::LatticePoint;
using mesh::MeshData;
using mesh::TriangleRecord;
using mesh::VertexId;
using mesh::VertexSource;

class CutAudit {
 public:
  CutAudit(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::CutPlan& plan,
           const cut::CutOutcome& outcome)
      : before_mesh_(before),
        after_mesh_(after),
        old_(before.data()),
        now_(after.data()),
        plan_(plan),
        outcome_(outcome),
        old_index_(old_) {}

  Finding run() {
    if (Finding found = find_flaw(after_mesh_, &census_)) return found;
    for (const auto check : {&CutAudit::check_characteristic, &CutAudit::check_areas, &CutAudit::check_parents,
                             &CutAudit::check_what_stays, &CutAudit::check_sources, &CutAudit::check_edit,
                             &CutAudit::check_pieces, &CutAudit::check_report}) {
      if (Finding found = (this->*check)()) return found;
    }
    if (takes_material()) {
      if (Finding found = find_strip_flaw(before_mesh_, after_mesh_, plan_, outcome_)) return found;
    }
    return find_path_flaw(before_mesh_, after_mesh_, plan_, outcome_.report);
  }

 private:
  [[nodiscard]] bool takes_material() const { return plan_.options.width_m.has_value(); }
  static std::string text(const char* what, VertexId v) { return std::string(what) + ": vertex " + std::to_string(v); }

  Finding check_characteristic() {
    Census before;
    if (Finding found = find_flaw(before_mesh_, &before)) return "before the cut: " + *found;
    if (takes_material()) return std::nullopt;
    if (census_.welded_characteristic() != before.welded_characteristic()) {
      return "the sheet, closed again along its cuts, has another Euler characteristic";
    }
    if (census_.pieces < before.pieces) return "pieces have grown together";
    if (census_.extra_fans == before.extra_fans && census_.pieces == before.pieces) return "the cut opened nothing";
    return std::nullopt;
  }

  // Checks that areas stay. The area of a removed strip is checked by find_strip_flaw().
  Finding check_areas() {
    if (takes_material()) return std::nullopt;
    std::map<std::int32_t, Wide> area;  // twice the change, by region
    std::map<std::int32_t, Wide> total;
    const auto add = [&](const MeshData& data, int sign) {
      for (const TriangleRecord& r : data.triangles) {
        if (!is_solid(r)) continue;
        const LatticePoint& a = data.points[index(r.points[0])].at;
        const Wide doubled =
            turn(minus(data.points[index(r.points[1])].at, a), minus(data.points[index(r.points[2])].at, a));
        area[r.region] += sign * doubled;
        total[r.region] += doubled;
      }
    };
    add(old_, -1);
    add(now_, 1);
    // On a curved sheet the bound uses the area of the whole sheet: a facet may be as small as a triangle, and
    // splitting its edges rounds.
    Wide whole = 0;
    for (const auto& [region, doubled] : total) whole += doubled;
    for (const auto& [region, change] : area) {
      const double allowed = 0.5e-12 * static_cast<double>(now_.surface ? whole : total[region]);
      if (std::abs(static_cast<double>(change)) > allowed) {
        return "region " + std::to_string(region) + " has lost or gained area";
      }
    }
    return std::nullopt;
  }

  // Returns the slot of the old solid triangle that contains `tripled` / 3, or the number of old slots if there is
  // none.
  std::size_t old_triangle_at(const LatticePoint& tripled) {
    const Vector2d place(static_cast<double>(tripled.x) / 3.0, static_cast<double>(tripled.y) / 3.0);
    std::size_t found = old_.triangles.size();
    old_index_.for_touching(Box(place.array() - 2.0, place.array() + 2.0),
                            [&](const TriangleRecord& r, std::size_t slot) {
                              for (std::size_t k = 0; k < 3; ++k) {
                                const LatticePoint& a = old_.points[index(r.points[k])].at;
                                const LatticePoint& b = old_.points[index(r.points[(k + 1) % 3])].at;
                                if (turn(minus(b, a), {tripled.x - 3 * a.x, tripled.y - 3 * a.y}) < 0) return;
                              }
                              found = slot;
                            });
    return found;
  }

  Finding check_parents() {
    for (const mesh::TriangleId t : outcome_.edit.rewritten_triangles) {
      if (t < 0 || index(t) >= now_.triangles.size()) return "a rewritten slot that does not exist";
      const TriangleRecord& r = now_.triangles[index(t)];
      if (!is_solid(r)) continue;
      const std::size_t parent = old_triangle_at(tripled_centre(now_, r));
      if (parent == old_.triangles.size()) return "slot " + std::to_string(t) + " lies where no material was";
      if (old_.triangles[parent].region != r.region) return "slot " + std::to_string(t) + " has the wrong region";
    }
    return std::nullopt;
  }

  Finding check_what_stays() {
    std::vector<bool> moved(old_.points.size());
    for (const VertexSource& source : outcome_.edit.moved_vertices) {
      const VertexId v = source.vertex;
      if (v < 0 || index(v) >= old_.vertices.size()) return text("moved, but not there before", v);
      const auto p = index(old_.vertices[index(v)].point);
      if (old_.points[p].at == now_.points[p].at) return text("said to have moved", v);
      moved[p] = true;
    }
    for (std::size_t p = 0; p < old_.points.size(); ++p) {
      if (!moved[p] && old_.points[p].at != now_.points[p].at) return "point " + std::to_string(p) + " has moved";
    }
    for (std::size_t v = 0; v < old_.vertices.size(); ++v) {
      if (old_.vertices[v].point != now_.vertices[v].point) return text("at another point", static_cast<VertexId>(v));
    }
    for (const VertexId v : plan_.fixed_vertices) {
      if (moved[index(old_.vertices[index(v)].point)]) return text("fixed and yet moved", v);
    }
    for (const TriangleRecord& r : old_.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (r.locks[k] == 0) continue;
        if (moved[index(r.points[(k + 1) % 3])] || moved[index(r.points[(k + 2) % 3])]) return "a lip has moved";
      }
    }
    return std::nullopt;
  }

  Finding check_sources() { return find_source_flaw(old_, now_, outcome_.edit, old_index_); }

  // Returns the record as in the opened mesh, which has no neighbours across lips and border.
  static TriangleRecord opened(TriangleRecord r) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (r.locks[k] == 0) continue;
      r.neighbours[k] = kNone;
      r.locks[k] = mesh::kLockBorder;  // a lip becomes border where the material across goes
    }
    return r;
  }

  // Checks the edit: replacing in the old opened mesh only what the edit lists must give the new one.
  Finding check_edit() {
    const auto& rewritten = outcome_.edit.rewritten_triangles;
    if (!std::is_sorted(rewritten.begin(), rewritten.end()) ||
        std::adjacent_find(rewritten.begin(), rewritten.end()) != rewritten.end()) {
      return "rewritten_triangles is not sorted and unique";
    }
    std::vector<bool> listed(now_.triangles.size());
    for (const mesh::TriangleId t : rewritten) listed[index(t)] = true;
    for (std::size_t t = 0; t < now_.triangles.size(); ++t) {
      if (listed[t]) continue;
      const std::string slot = "slot " + std::to_string(t);
      if (t >= old_.triangles.size()) return slot + " is new but not listed";
      TriangleRecord expected = opened(old_.triangles[t]);
      const TriangleRecord is = opened(now_.triangles[t]);
      if (is_solid(is) || is_solid(expected)) {
        expected.piece = is.piece;
        if (!(expected == is)) return slot + " changed but is not listed";
        for (const mesh::PointId p : is.points) {
          if (old_.points[index(p)].at != now_.points[index(p)].at) return slot + " changed shape but is not listed";
        }
      }
    }
    return std::nullopt;
  }

  // Returns the number that a piece had before the numbers of completely removed pieces were reused.
  [[nodiscard]] std::int32_t before_renumbering(std::int32_t piece) const {
    const auto& vanished = outcome_.edit.removed_pieces;
    std::int32_t count = now_.num_pieces;
    for (auto gone = vanished.rbegin(); gone != vanished.rend(); ++gone, ++count) {
      if (piece == *gone) piece = count;
    }
    return piece;
  }

  Finding check_pieces() {
    std::vector<std::int32_t> parent(index(now_.num_pieces) + outcome_.edit.removed_pieces.size(), kNone);
    for (std::size_t t = 0; t < old_.triangles.size(); ++t) {
      const std::int32_t was = old_.triangles[t].piece;
      std::int32_t is = now_.triangles[t].piece;
      if (was == kNone) continue;
      if (std::binary_search(outcome_.edit.rewritten_triangles.begin(), outcome_.edit.rewritten_triangles.end(),
                             static_cast<mesh::TriangleId>(t))) {
        continue;
      }
      is = before_renumbering(is);
      if (is < old_.num_pieces && is != was) return "slot " + std::to_string(t) + " went over to another old piece";
      if (parent[index(is)] == kNone) parent[index(is)] = was;
      if (parent[index(is)] != was) return "piece " + std::to_string(is) + " comes from two";
    }
    return std::nullopt;
  }

  Finding check_report() {
    const cut::CutReport& report = outcome_.report;
    if (report.deviation_m > largest_tolerance(before_mesh_, plan_) || report.deviation_of_tolerance > 1.0) {
      return "the deviation is beyond the tolerance";
    }
    const auto expect = [](const char* name, std::int64_t said, std::int64_t is) -> Finding {
      if (said == is) return std::nullopt;
      return std::string(name) + " is said to be " + std::to_string(said) + " and is " + std::to_string(is);
    };
    const auto size = [](const auto& list) { return static_cast<std::int64_t>(list.size()); };
    for (const Finding& found :
         {expect("pieces", report.pieces, census_.pieces),
          expect("new_vertices", report.new_vertices, size(now_.vertices) - size(old_.vertices)),
          expect("new_triangles", report.new_triangles, solid_in_new_slots()),
          expect("rewritten_triangles", report.rewritten_triangles, size(outcome_.edit.rewritten_triangles)),
          expect("moved_vertices", report.moved_vertices, size(outcome_.edit.moved_vertices))}) {
      if (found) return found;
    }
    return find_shape_flaw(old_, now_, old_index_.solid_slots(), outcome_);
  }

  [[nodiscard]] std::int64_t solid_in_new_slots() const {
    return std::count_if(now_.triangles.begin() + static_cast<std::ptrdiff_t>(old_.triangles.size()),
                         now_.triangles.end(), is_solid);
  }

  const mesh::TriangleMesh& before_mesh_;
  const mesh::TriangleMesh& after_mesh_;
  const MeshData& old_;
  const MeshData& now_;
  const cut::CutPlan& plan_;
  const cut::CutOutcome& outcome_;
  Census census_;
  OldMeshIndex old_index_;
};

}  // namespace

Finding find_cut_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::CutPlan& plan,
                      const cut::CutOutcome& outcome) {
  return CutAudit(before, after, plan, outcome).run();
}

Finding find_difference(const mesh::TriangleMesh& a, const mesh::TriangleMesh& b) {
  const MeshData& x = a.data();
  const MeshData& y = b.data();
  if (!(x.lattice == y.lattice)) return "the lattices differ";
  if (x.bounds.min() != y.bounds.min() || x.bounds.max() != y.bounds.max()) return "the bounds differ";
  if (!(x.lengths == y.lengths)) return "the edge lengths differ";
  if (x.points != y.points) return "the points differ";
  if (x.vertices != y.vertices) return "the vertices differ";
  if (x.triangles != y.triangles) return "the triangles differ";
  if (x.num_solid_triangles != y.num_solid_triangles) return "the numbers of triangles differ";
  if (x.num_pieces != y.num_pieces) return "the numbers of pieces differ";
  if (!a.has_surface_of(b)) return "the rest surfaces differ";
  return std::nullopt;
}

}  // namespace kerf::audit
