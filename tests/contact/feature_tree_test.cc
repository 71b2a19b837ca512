#include "server/core/contact/feature_tree.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/contact/lattice_sheet.h"
#include "tests/contact/pair_brute_force.h"
#include "tests/contact/pair_distance.h"
#include "tests/contact/random_vector.h"
#include "tests/support/meshes.h"

namespace kerf::contact {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Kind = FeaturePair::Kind;
using mesh::VertexId;
using Key = std::tuple<Kind, std::int32_t, std::int32_t>;

constexpr double kReach = 5e-4;           // m
constexpr double kSheetThickness = 5e-4;  // m

Key key_of(const FeaturePair& pair) {
  return {pair.kind, pair.a, pair.b};
}

// Checks what is found for a sheet. Returns the number of pairs.
std::size_t expect_all_pairs(const Moving& sheet, const std::string& what) {
  FeatureTree tree;
  tree.set(sheet.mesh);
  std::vector<FeaturePair> pairs(3);
  tree.find_pairs({sheet.x, sheet.v, sheet.duration}, kReach, sheet.slack, kSheetThickness, pairs);
  const SheetFeatures& features = tree.features();
  const BruteForce all(features, sheet);

  std::set<Key> found;
  bool is_ordered = true;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const FeaturePair& pair = pairs[k];
    Key key = key_of(pair);
    if (pair.kind == Kind::kEdgeEdge && pair.a > pair.b) key = {pair.kind, pair.b, pair.a};
    EXPECT_TRUE(found.insert(key).second) << what << ": a pair twice";
    is_ordered = is_ordered && (k == 0 || pairs[k - 1].kind <= pair.kind);
    const double at_rest = all.distance_at_rest(pair);
    EXPECT_NEAR(pair.thickness, std::max(std::min(kSheetThickness, 0.5 * at_rest), 2.0 * pair.least), 1e-9) << what;
    double least = 0.02 * kSheetThickness;
    for (const VertexId v : pair.vertices) {
      least = std::min(least, 0.02 * features.altitude_at[static_cast<std::size_t>(v)]);
    }
    EXPECT_DOUBLE_EQ(pair.least, least) << what;
    std::array<VertexId, 4> expected{};
    if (pair.kind == Kind::kVertexTriangle) {
      const auto& c = features.triangles[static_cast<std::size_t>(pair.b)].vertices;
      expected = {pair.a, c[0], c[1], c[2]};
    } else {
      const auto& p = features.edges[static_cast<std::size_t>(pair.a)].vertices;
      const auto& q = features.edges[static_cast<std::size_t>(pair.b)].vertices;
      expected = {p[0], p[1], q[0], q[1]};
    }
    EXPECT_EQ(pair.vertices, expected) << what;
    for (std::size_t i = 0; i < pair.num_a(); ++i) {
      EXPECT_EQ(std::count(expected.begin() + static_cast<std::ptrdiff_t>(pair.num_a()), expected.end(), expected[i]),
                0)
          << what << ": a common vertex";
    }
    // Nothing that is far away.
    double fastest = 0.0, slack = 0.0;
    for (const VertexId v : pair.vertices)
      slack = std::max(slack, static_cast<double>(sheet.slack[static_cast<std::size_t>(v)]));
    for (std::size_t i = 0; i < pair.num_a(); ++i) {
      for (std::size_t j = pair.num_a(); j < 4; ++j) {
        fastest = std::max(fastest, (sheet.v.col(pair.vertices[i]) - sheet.v.col(pair.vertices[j])).norm());
      }
    }
    EXPECT_LT(wide_distance(pair.kind, positions_of(pair, sheet.x)),
              kReach + 2.0 * slack + sheet.duration * fastest + 1e-4 * sheet.edge() + 1e-5)
        << what;
  }
  EXPECT_TRUE(is_ordered) << what;

  // Pairs in a flat part are left out; they keep 5 % of their distance at rest.
  std::size_t num_required = 0, num_missed = 0;
  all.for_each([&](const FeaturePair& pair) {
    const double least = all.least(pair, kReach);
    if (!(least < kReach - 1e-6) || !(least < 0.05 * all.distance_at_rest(pair))) return;
    ++num_required;
    if (found.contains(key_of(pair))) return;
    if (++num_missed <= 3) {
      ADD_FAILURE() << what << ": kind " << static_cast<int>(pair.kind) << " of vertices " << pair.vertices[0] << ", "
                    << pair.vertices[1] << ", " << pair.vertices[2] << ", " << pair.vertices[3] << " comes as near as "
                    << least << " m, at rest " << all.distance_at_rest(pair);
    }
  });
  EXPECT_EQ(num_missed, 0U) << what << ", of " << num_required;
  return num_required;
}

TEST(FeatureTree, FindsNoPairsInAFlatSheet) {
  for (const mesh::TriangleMesh& mesh : {test::grid(30), test::jittered_grid(30, 1), test::union_jack(20)}) {
    FeatureTree tree;
    tree.set(mesh);
    std::vector<FeaturePair> pairs;
    for (const double bend : {0.0, 0.3, 1.0, 2.0}) {
      Moving sheet(mesh, placed(mesh, [bend](const Vector2d& p, int) {
                     return bend == 0.0 ? Vector3d(0.8 * p.x() - 0.6 * p.y(), 0.6 * p.x() + 0.8 * p.y(), 7.0)
                                        : Vector3d(std::sin(bend * p.x()) / bend, p.y(), std::cos(bend * p.x()) / bend);
                   }));
      for (VertexId v = 0; v < mesh.num_vertices(); ++v)
        sheet.v.col(v) = Vector3d(3.0, 100.0, 0.0) + sheet.x.col(v).cross(Vector3d(1.0, 2.0, 3.0));
      pairs.resize(1);
      tree.find_pairs({sheet.x, sheet.v, sheet.duration}, kReach, sheet.slack, kSheetThickness, pairs);
      EXPECT_TRUE(pairs.empty()) << pairs.size() << ", bent by " << bend;
    }
  }
}

// A spiral whose layers are `apart`, m.
Vector3d rolled(const Vector2d& p, double radius, double apart) {
  // The arc length of a spiral of radius r = radius + apart angle / (2 pi), nearly.
  const double growth = apart / (2.0 * std::numbers::pi);
  const double angle = (std::sqrt(radius * radius + 2.0 * growth * p.x()) - radius) / growth;
  const double r = radius + growth * angle;
  return {r * std::cos(angle), p.y(), r * std::sin(angle)};
}

TEST(FeatureTree, FindsAllPairsOfASheetThatIsRolledTwice) {
  const mesh::TriangleMesh mesh =
      LatticeSheet{.columns = 40, .rows = 4, .edge = 0.025, .slit = 0, .slit_begin = 0, .slit_end = 0, .is_hole = {}}
          .mesh();
  for (const double apart : {1e-3}) {
    Moving sheet(mesh, placed(mesh, [apart](const Vector2d& p, int) { return rolled(p, 0.0795, apart); }));
    EXPECT_GT(expect_all_pairs(sheet, "rolled"), 500U);
    sheet.v = -30.0 * sheet.x;
    EXPECT_GT(expect_all_pairs(sheet, "rolled, shrinking"), 500U);
  }
}

TEST(FeatureTree, FindsAllPairsOfASheetThatIsFolded) {
  for (const mesh::TriangleMesh& mesh : {test::grid(13), test::jittered_grid(13, 2), test::union_jack(13)}) {
    Moving sheet(mesh, placed(mesh, [](const Vector2d& p, int) {
                   constexpr double kRadius = 1e-3;  // m, half the distance of the layers
                   const double fold = 0.48, angle = (p.x() - fold) / kRadius;
                   if (angle <= 0.0) return Vector3d(p.x(), p.y(), 0.0);
                   if (angle >= std::numbers::pi)
                     return Vector3d(2.0 * fold + std::numbers::pi * kRadius - p.x(), p.y(), 2.0 * kRadius);
                   return Vector3d(fold + kRadius * std::sin(angle), p.y(), kRadius - kRadius * std::cos(angle));
                 }));
    EXPECT_GT(expect_all_pairs(sheet, "folded"), 500U);
    // The upper layer slides over the lower one and falls on it.
    for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
      if (sheet.x(2, v) > 1e-3) sheet.v.col(v) = Vector3d(4.0, -7.0, -1.0);
    }
    EXPECT_GT(expect_all_pairs(sheet, "folded, sliding"), 500U);
  }
}

TEST(FeatureTree, FindsAllPairsOfACrumpledSheet) {
  SeededRandom random(1);
  for (int k = 0; k < 6; ++k) {
    const mesh::TriangleMesh mesh =
        k % 2 == 0 ? test::grid(12) : test::jittered_grid(12, static_cast<std::uint64_t>(k));
    const double noise = k < 3 ? 0.03 : 0.3;
    Moving sheet(mesh, placed(mesh, [&](const Vector2d& p, int) {
                   const Vector3d wave(std::sin(7 * p.x() + 2 * p.y()), std::sin(5 * p.y() - 3 * p.x() * p.y()),
                                       std::cos(9 * p.x() * p.y()));
                   return Vector3d(0.3 * wave + random_vector(random, noise));
                 }));
    for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
      sheet.v.col(v) = random_vector(random, k % 3 == 0 ? 1.0 : 20.0);
      sheet.slack[static_cast<std::size_t>(v)] *= static_cast<float>(random.uniform(0.1, 4.0));
    }
    EXPECT_GT(expect_all_pairs(sheet, "crumpled " + std::to_string(k)), 200U);
  }
}

TEST(FeatureTree, FindsAllPairsAtLips) {
  const mesh::TriangleMesh mesh = with_slit();
  Moving sheet(mesh, placed(mesh, [](const Vector2d& p, int) { return in_plane(p); }));
  EXPECT_GT(expect_all_pairs(sheet, "flat, with lips"), 20U);
  // Lips that slide over each other, at almost no strain, and ones that close only later.
  for (const double way : {0.02, -0.02}) {
    for (const bool moves : {false, true}) {
      const auto lips = [&](VertexId v) {
        const Vector2d p = mesh.rest_position(v);
        const VertexId right_side = mesh.rest_position(v).x() > 0.5 ? 1 : 0;
        std::vector<mesh::TriangleId> ring;
        mesh.triangles_around(v, ring);
        double centre = 0.0;
        for (const mesh::TriangleId t : ring) {
          for (const VertexId c : mesh.vertices(t))
            centre += mesh.rest_position(c).x() / (3.0 * static_cast<double>(ring.size()));
        }
        const double side = right_side == 1 || centre > 0.52 ? 1.0 : centre < 0.48 ? -1.0 : 0.0;
        const double share =
            std::max(0.0, 1.0 - std::abs(p.x() - 0.5) / 0.3) * std::max(0.0, 1.0 - std::abs(p.y() - 0.5) / 0.25);
        return Vector3d(way * side * share, 0.0, -0.001 * side * share);
      };
      for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
        sheet.x.col(v) = in_plane(mesh.rest_position(v)) + (moves ? -1.0 : 1.0) * lips(v);
        sheet.v.col(v) = moves ? Vector3d(2.0 / sheet.duration * lips(v)) : Vector3d::Zero();
      }
      const std::size_t number = expect_all_pairs(sheet, "lips that moved by " + std::to_string(way));
      EXPECT_TRUE(number > 20U || (way > 0.0 && !moves)) << number;
    }
  }
}

TEST(FeatureTree, FindsAllPairsOfTwoPieces) {
  const mesh::TriangleMesh mesh = in_two_pieces();
  ASSERT_EQ(mesh.num_pieces(), 2);
  SeededRandom random(3);
  for (int k = 0; k < 8; ++k) {
    const Vector3d shift(random.uniform(-0.6, -0.1), random.uniform(-0.3, 0.3), 0.001),
        speed = random_vector(random, k < 4 ? 0.0 : 2.0);
    const double tilt = k % 2 == 0 ? 0.0 : 0.3;
    const int moved = mesh.piece(mesh.triangle_at(mesh.num_vertices() - 1));
    Moving sheet(mesh, placed(mesh, [&](const Vector2d& p, int piece) {
                   return piece == moved ? Vector3d(in_plane(p) + shift + Vector3d(0.0, 0.0, tilt * (p.x() - 0.8)))
                                         : in_plane(p);
                 }));
    for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
      sheet.v.col(v) = mesh.piece(mesh.triangle_at(v)) == moved ? speed : Vector3d::Zero();
    }
    EXPECT_GT(expect_all_pairs(sheet, "two pieces " + std::to_string(k)), 10U);
  }
}

TEST(FeatureTree, FindsAllPairsOfArmsAndAroundAHole) {
  const mesh::TriangleMesh mesh = with_arms_and_a_hole();
  for (const double bend : {0.045, 0.06, 0.15}) {
    for (const bool moves : {false, true}) {
      // Both arms bend towards each other in the plane, one a little above the other. The hole closes.
      const auto way = [bend](const Vector2d& p) {
        const double up = std::max(0.0, p.y() - 0.4) / 0.6, side = p.x() < 0.45 ? 1.0 : -1.0;
        const double closes = p.x() > 0.25 && p.x() < 0.65 && p.y() > 0.25 && p.y() < 0.35 ? -0.101 * bend / 0.06 : 0.0;
        return Vector3d(bend * up * up * side, closes, 0.0005 * side * up);
      };
      Moving sheet(mesh, placed(mesh, [&](const Vector2d& p, int) {
                     return Vector3d(in_plane(p) + (moves ? 0.0 : 1.0) * way(p));
                   }));
      if (moves) {
        for (VertexId v = 0; v < mesh.num_vertices(); ++v) sheet.v.col(v) = way(mesh.rest_position(v)) / sheet.duration;
      }
      const std::size_t number = expect_all_pairs(sheet, "arms bent by " + std::to_string(bend));
      EXPECT_TRUE(number > 20U || bend < 0.05) << number;
    }
  }
}

// Tubes, hairpins and cones of all angles, shrunk and sheared, so that some parts just may be taken for flat.
TEST(FeatureTree, TakesNothingForFlatThatMayTouchItself) {
  SeededRandom random(4);
  std::size_t number = 0;
  for (int k = 0; k < 24; ++k) {
    const mesh::TriangleMesh mesh =
        k % 2 == 0 ? test::grid(10) : test::jittered_grid(10, static_cast<std::uint64_t>(k));
    const double angle = random.uniform(1.0, 6.4), slant = random.uniform(-0.6, 0.6),
                 shrink = random.uniform(0.05, 1.0);
    const double cone = k % 3 == 0 ? random.uniform(0.0, 1.0) : 0.0, wave = k % 5 == 0 ? 0.1 : 0.0;
    Moving sheet(mesh, placed(mesh, [&](const Vector2d& p, int) {
                   const double at = p.x() + slant * (p.y() - 0.5);
                   const double radius = (1.0 - cone * p.y()) / angle;
                   return Vector3d(radius * std::sin(angle * at), shrink * p.y() + wave * std::sin(9.0 * at),
                                   radius * std::cos(angle * at));
                 }));
    const double speed = k % 4 == 0 ? 0.0 : random.uniform(1.0, 80.0);
    const Vector3d axis = random_vector(random, 1.0);
    for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
      const Vector2d p = mesh.rest_position(v);
      sheet.v.col(v) = speed * (std::sin(angle * p.x() + 2.0 * p.y()) * axis + random_vector(random, 0.05)) -
                       (k % 7 == 0 ? 150.0 : 0.0) * sheet.x.col(v);
      sheet.slack[static_cast<std::size_t>(v)] *= static_cast<float>(random.uniform(0.5, 4.0));
    }
    number += expect_all_pairs(sheet, "bent " + std::to_string(k));
  }
  EXPECT_GT(number, 500U);
}

// Single vertices of a flat sheet that move far, and whole parts of it that collapse.
TEST(FeatureTree, TakesNothingForFlatWhereAVertexStrays) {
  SeededRandom random(5);
  std::size_t number = 0;
  for (int k = 0; k < 24; ++k) {
    const mesh::TriangleMesh mesh =
        k % 2 == 0 ? test::grid(10) : test::jittered_grid(10, static_cast<std::uint64_t>(k));
    Moving sheet(mesh, placed(mesh, [&](const Vector2d& p, int) { return in_plane(p); }));
    for (int i = 0; i < 3; ++i) {
      const auto v = static_cast<VertexId>(random.below(static_cast<std::uint64_t>(mesh.num_vertices())));
      const Vector3d way = random_vector(random, 0.15);
      sheet.x.col(v) += random.uniform() * way;
      sheet.v.col(v) = random.uniform() / sheet.duration * way;
      sheet.slack[static_cast<std::size_t>(v)] *= 3.0F;
    }
    number += expect_all_pairs(sheet, "strays " + std::to_string(k));
  }
  EXPECT_GT(number, 20U);
}

// The pairs of vertices whose lines change are found again, also where find_pairs() saw a flat part.
TEST(FeatureTree, FollowsVerticesThatLeaveTheirLines) {
  SeededRandom random(6);
  std::size_t number = 0;
  for (int k = 0; k < 12; ++k) {
    const mesh::TriangleMesh mesh = test::jittered_grid(10, static_cast<std::uint64_t>(k));
    Moving sheet(mesh, placed(mesh, [&](const Vector2d& p, int) {
                   return Vector3d(0.15 * std::sin(6.0 * p.x()), p.y(), 0.15 * std::cos(6.0 * p.x()));
                 }));
    for (VertexId v = 0; v < mesh.num_vertices(); ++v) sheet.v.col(v) = random_vector(random, 1.0);
    FeatureTree tree;
    tree.set(mesh);
    std::vector<FeaturePair> pairs;
    tree.find_pairs({sheet.x, sheet.v, sheet.duration}, kReach, sheet.slack, kSheetThickness, pairs);
    ASSERT_TRUE(tree.is_fitted());
    for (int again = 0; again < 3; ++again) {
      // From `since` on some vertices go elsewhere; the others keep their lines.
      const double since = 1e-3 * again;
      Moving now = sheet;
      now.x = sheet.x + since * sheet.v;
      now.duration = sheet.duration - since;
      std::vector<VertexId> strayed;
      for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
        if (random.below(10) != 0) continue;
        strayed.push_back(v);
        now.x.col(v) += random_vector(random, 0.05);
        now.v.col(v) = random_vector(random, 20.0);
        now.slack[static_cast<std::size_t>(v)] *= 2.0F;
        sheet.v.col(v) = now.v.col(v);
        sheet.x.col(v) = now.x.col(v) - since * now.v.col(v);
      }
      sheet.slack = now.slack;
      tree.follow(strayed, sheet.x, sheet.v, since, kReach, now.slack, kSheetThickness, pairs);
      std::set<Key> found;
      for (const FeaturePair& pair : pairs) {
        Key key = key_of(pair);
        if (pair.kind == Kind::kEdgeEdge && pair.a > pair.b) key = {pair.kind, pair.b, pair.a};
        EXPECT_TRUE(found.insert(key).second) << "a pair twice";
      }
      const BruteForce all(tree.features(), now);
      const auto has_strayed = [&](const FeaturePair& pair) {
        return std::find_first_of(pair.vertices.begin(), pair.vertices.end(), strayed.begin(), strayed.end()) !=
               pair.vertices.end();
      };
      for (const FeaturePair& pair : pairs) EXPECT_TRUE(has_strayed(pair));
      all.for_each([&](const FeaturePair& pair) {
        if (!has_strayed(pair) || !(all.least(pair, kReach) < kReach - 1e-5)) return;
        ++number;
        EXPECT_TRUE(found.contains(key_of(pair))) << k << ", " << again << ": " << all.least(pair, kReach);
      });
    }
  }
  EXPECT_GT(number, 300U);
}

}  // namespace
}  // namespace kerf::contact
