// Materials, the model and how it follows edits of the mesh.
#include <limits>

#include "server/core/fem/model/transfer.h"
#include "server/core/linear/row_store.h"
#include "server/core/mesh/mesh_editor.h"
#include "tests/fem/fixture.h"
#include "tests/support/matrix_near.h"
#include "tests/support/meshes.h"
#include "tests/support/trials.h"

namespace kerf::fem {
namespace {

TEST(Material, EveryPresetIsValidAndFoundByName) {
  EXPECT_GE(preset_names().size(), 7U);
  for (const std::string_view name : preset_names()) {
    const Result<Material> found = find_preset(name);
    ASSERT_TRUE(found.ok()) << name;
    EXPECT_TRUE(validate(*found).ok()) << name;
  }
  const Material wool = find_preset("wool").value();
  EXPECT_EQ(wool.youngs_modulus_1, 3.1e9);
  EXPECT_EQ(wool.shear_modulus, 0.51e9);
  EXPECT_EQ(wool.poissons_ratio_12, 0.63);
  EXPECT_EQ(wool.density, 1300.0);
  EXPECT_EQ(wool.thickness, 5e-4);
}

TEST(Model, BendingIsSymmetricAroundAVertexOfThreeTriangles) {
  // Across two edges of each triangle lies the same vertex, which is in its patch twice.
  const mesh::TriangleMesh mesh = kerf::test::must(mesh::import_mesh(
      kerf::test::indexed({{0.0, 0.0}, {1.0, 0.0}, {0.4, 0.9}, {0.45, 0.3}}, {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}})));
  const Model model(mesh, find_preset("demo").value());
  ASSERT_TRUE(model.materials().has_bending());
  const auto value = [&](int i, int j) {
    for (const BendingEntry& entry : model.bending().rows().row(i)) {
      if (entry.column == j) return entry.value;
    }
    return 0.0;
  };
  for (int i = 0; i < 4; ++i) {
    double sum = 0.0;
    for (int j = 0; j < 4; ++j) {
      EXPECT_NEAR(value(i, j), value(j, i), 1e-12 * std::abs(value(0, 0))) << i << " " << j;
      sum += value(i, j);
    }
    EXPECT_NEAR(sum, 0.0, 1e-12 * std::abs(value(0, 0))) << i;
  }
  EXPECT_GT(std::abs(value(0, 0)), 0.0);
}

TEST(Material, UnknownPresetIsNotFoundAndListsTheKnownOnes) {
  const Result<Material> found = find_preset("adamantium");
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error().code, ErrorCode::kNotFound);
  EXPECT_NE(found.error().message.find("cotton"), std::string::npos);
}

TEST(Material, PresetsAreValidAndAllThere) {
  const std::vector<std::string_view> names(preset_names().begin(), preset_names().end());
  EXPECT_EQ(names, (std::vector<std::string_view>{"demo", "wool", "cotton", "denim", "silk", "rubber", "paper", "skin",
                                                  "foil"}));
  for (const std::string_view name : names) EXPECT_TRUE(validate(find_preset(name).value()).ok()) << name;
}

TEST(Material, PresetsHaveTheMeasuredNumbersOfTheirSources) {
  // KES-F units in SI; see material_presets.cc.
  constexpr double kShear = 0.980665 * 57.29578;  // N/m, of gf/(cm degree)
  constexpr double kBending = 9.80665e-5;         // N m, of gf cm^2/cm
  const Material denim = find_preset("denim").value();
  const double extension = 0.05515;
  const double energy = 0.5 * extension * 500.0 * 0.712 * 0.980665;  // N/m: linearity 0.712 up to 500 gf/cm
  const double stretched = 0.5 * denim.youngs_modulus_1 * denim.thickness * extension * extension;
  EXPECT_NEAR(stretched, energy, 1e-3 * energy);
  EXPECT_NEAR(denim.shear_modulus * denim.thickness, 2.180 * kShear, 1e-3 * 2.180 * kShear);
  EXPECT_NEAR(bending_law(denim)(0, 0), 0.172 * kBending, 1e-3 * 0.172 * kBending);
  EXPECT_NEAR(denim.density * denim.thickness, 0.324, 1e-3);
  const Material wool = find_preset("wool").value();
  EXPECT_EQ(wool.youngs_modulus_1, 3.1e9);
  EXPECT_EQ(wool.shear_modulus, 0.51e9);
  EXPECT_EQ(wool.poissons_ratio_12, 0.63);
  EXPECT_EQ(wool.density, 1300.0);
  const Material paper = find_preset("paper").value();
  const double baum = 0.387 * std::sqrt(paper.youngs_modulus_1 * paper.youngs_modulus_2);
  EXPECT_NEAR(paper.shear_modulus, baum, 0.01 * baum);
  const Material foil = find_preset("foil").value();
  EXPECT_NEAR(foil.shear_modulus, foil.youngs_modulus_1 / (2.0 * (1.0 + foil.poissons_ratio_12)), 1e7);
}

TEST(Material, RefusesEveryFieldThatIsNotFiniteOrOutOfRangeByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<std::pair<double Material::*, std::string>> fields{
      {&Material::youngs_modulus_1, "youngs_modulus_pa"},
      {&Material::youngs_modulus_2, "youngs_modulus_2_pa"},
      {&Material::shear_modulus, "shear_modulus_pa"},
      {&Material::poissons_ratio_12, "poissons_ratio"},
      {&Material::direction, "direction_rad"},
      {&Material::thickness, "thickness_m"},
      {&Material::density, "density_kgpm3"},
      {&Material::bending_scale, "bending_scale"},
      {&Material::mass_damping, "mass_damping_per_s"},
      {&Material::stiffness_damping, "stiffness_damping_s"}};
  for (const auto& [member, name] : fields) {
    for (const double bad : {nan, inf, -inf, 1e300, -1e300}) {
      Material material;
      material.*member = bad;
      const Status status = validate(material, "scene.material");
      ASSERT_FALSE(status.ok()) << name << " " << bad;
      EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
      EXPECT_EQ(status.error().field, "scene.material." + name);
    }
  }
}

TEST(Material, RangesIncludeTheirEnds) {
  for (const auto& [member, range] :
       std::vector<std::pair<double Material::*, Range>>{{&Material::thickness, MaterialRanges::kThickness},
                                                         {&Material::mass_damping, MaterialRanges::kMassDamping}}) {
    Material material;
    for (const double end : {range.low, range.high}) {
      material.*member = end;
      EXPECT_TRUE(validate(material).ok()) << end;
    }
    material.*member = range.high * (1.0 + 1e-15);
    EXPECT_FALSE(validate(material).ok());
  }
}

TEST(Material, PoissonRatioIsLimitedByPositiveDefinitenessAlone) {
  Material material;
  material.poissons_ratio_12 = 0.99;  // allowed: the shear modulus is independent
  EXPECT_TRUE(validate(material).ok());
  material.poissons_ratio_12 = 1.0;
  ASSERT_FALSE(validate(material).ok());
  EXPECT_EQ(validate(material).error().reason, "MATERIAL_NOT_POSITIVE_DEFINITE");
  material.youngs_modulus_1 = 4.0 * material.youngs_modulus_2;
  material.poissons_ratio_12 = 1.9;  // nu12^2 E2 / E1 = 0.9
  EXPECT_TRUE(validate(material).ok());
  EXPECT_GT(membrane_law(material).determinant(), 0.0);
}

TEST(RowStore, KeepsRowsThroughGrowthAndPacking) {
  linear::RowStore<int> store;
  std::vector<std::vector<int>> expected(50);
  store.resize(50);
  SeededRandom random(5);
  for (int turn = 0; turn < 5000; ++turn) {
    const std::size_t i = random.below(50);
    expected[i].resize(random.below(40));
    for (int& value : expected[i]) value = static_cast<int>(random.below(1000));
    store.set_row(static_cast<int>(i), expected[i]);
  }
  std::size_t total = 0;
  for (std::size_t i = 0; i < 50; ++i) {
    const std::span<const int> row = store.row(static_cast<int>(i));
    EXPECT_TRUE(std::equal(row.begin(), row.end(), expected[i].begin(), expected[i].end()));
    total += expected[i].size();
  }
  EXPECT_EQ(store.num_entries(), total);
}

TEST(RowStore, WithRoomMadeRowsGrowWithoutMovingTheOthers) {
  linear::RowStore<int> store;
  store.resize(128);  // full: 512 entries
  const std::vector<int> content{1, 2, 3, 4};
  for (int i = 0; i < 128; ++i) store.set_row(i, content);
  store.make_room();
  const int* const first = store.row(0).data();
  for (int i = 108; i < 128; ++i) store.set_row(i, std::vector<int>{5, 6, 7, 8, 9});
  EXPECT_EQ(store.row(0).data(), first);
  EXPECT_TRUE(std::equal(content.begin(), content.end(), store.row(0).begin(), store.row(0).end()));
}

TEST(Model, MassIsAThirdOfEachTriangleAndAddsUp) {
  const mesh::TriangleMesh mesh = square_grid(3, 2.0);
  Material material = isotropic(1e6, 0.3, 1e-3, 500.0);
  const Model model(mesh, material);
  EXPECT_NEAR(model.masses().total(), 500.0 * 1e-3 * 4.0, 1e-14);
  EXPECT_NEAR(model.mass()[4], 500.0 * 1e-3 * 6.0 * 0.5 / 3.0, 1e-15);  // six triangles of 0.5 m^2
  EXPECT_NEAR(model.mass()[4] * model.inverse_mass()[4], 1.0, 1e-15);
}

TEST(Model, BendingRowsSumToZeroAndAreSymmetric) {
  const mesh::TriangleMesh mesh = jittered_square(8);
  const Model model(mesh, orthotropic_cloth());
  for (int i = 0; i < model.num_vertices(); ++i) {
    double sum = 0.0;
    double size = 0.0;
    for (const BendingEntry& entry : model.bending().rows().row(i)) {
      sum += entry.value;
      size += std::abs(entry.value);
      const std::span<const BendingEntry> other = model.bending().rows().row(entry.column);
      EXPECT_NE(std::find(other.begin(), other.end(), BendingEntry{entry.value, i}), other.end());
    }
    EXPECT_LT(std::abs(sum), 1e-12 * size);
  }
}

TEST(Model, WithoutBendingScaleHasNoBending) {
  Material material = orthotropic_cloth();
  material.bending_scale = 0.0;
  const mesh::TriangleMesh mesh = square_grid(4);
  const Model model(mesh, material);
  EXPECT_FALSE(model.materials().has_bending());
  EXPECT_EQ(model.bending().rows().num_entries(), 0U);
  State state = rest_state(mesh);
  state.x.row(2) = state.x.row(0).cwiseAbs2();
  EXPECT_EQ(model.energies(state, Eigen::Vector3d::Zero()).bending, 0.0);
}

// Random edits of one mesh: points inserted, edges flipped and cut, points moved.
class RandomEdits {
 public:
  explicit RandomEdits(std::uint64_t seed) : random_(seed) {}

  mesh::MeshEdit next(mesh::TriangleMesh& mesh) {
    mesh::MeshEditor editor(mesh);
    const int num_operations = 1 + static_cast<int>(random_.below(6));
    for (int i = 0; i < num_operations; ++i) {
      const auto slot =
          static_cast<mesh::TriangleId>(random_.below(static_cast<std::uint64_t>(mesh.num_triangle_slots())));
      if (!mesh.is_solid(slot)) continue;
      const int corner = static_cast<int>(random_.below(3));
      switch (random_.below(4)) {
        case 0:
          insert_point(mesh, editor, slot);
          break;
        case 1:
          editor.flip_edge(slot, corner);
          break;
        case 2:
          editor.lock_edge(slot, corner, mesh::kLockCut);
          break;
        default:
          editor.move_point(mesh.points(slot)[static_cast<std::size_t>(corner)], inside(mesh, slot, 0.8));
      }
    }
    return editor.commit().edit;
  }

 private:
  // A point of the triangle; with `pull` near 1, close to corner 0.
  mesh::LatticePoint inside(const mesh::TriangleMesh& mesh, mesh::TriangleId slot, double pull) {
    const std::array<mesh::PointId, 3>& p = mesh.points(slot);
    const double a = 0.5 * (1.0 - pull) * random_.uniform(0.2, 1.0);
    const double b = 0.5 * (1.0 - pull) * random_.uniform(0.2, 1.0);
    return mesh.lattice().nearest((1.0 - a - b) * mesh.point_position(p[0]) + a * mesh.point_position(p[1]) +
                                  b * mesh.point_position(p[2]));
  }
  void insert_point(const mesh::TriangleMesh& mesh, mesh::MeshEditor& editor, mesh::TriangleId slot) {
    const mesh::PointId p = editor.split_triangle(slot, inside(mesh, slot, 0.2));
    if (p != mesh::kNone) editor.legalise(p);
  }

  SeededRandom random_;
};

TEST(ModelEdit, FollowsEveryEditBitForBit) {
  for (const bool jittered : {false, true}) {
    mesh::TriangleMesh mesh = jittered ? jittered_square(12) : square_grid(12);
    Model model(mesh, orthotropic_cloth());
    RandomEdits edits(11);
    int num_changed = 0;
    const int num_edits = test::num_trials({.few = 80, .usual = 300, .many = 300});
    for (int i = 0; i < num_edits; ++i) {
      const mesh::MeshEdit edit = edits.next(mesh);
      model.apply(mesh, edit);
      num_changed += edit.rewritten_triangles.empty() ? 0 : 1;
      const Model rebuilt(mesh, orthotropic_cloth());
      ASSERT_EQ(model.hash(), rebuilt.hash()) << "edit " << i;
    }
    EXPECT_GT(num_changed, num_edits / 2);
    EXPECT_GT(mesh.num_pieces() + mesh.num_vertices(), 145 + num_edits / 6);
  }
}

TEST(ModelEdit, AnEmptyEditChangesNothing) {
  const mesh::TriangleMesh mesh = square_grid(5);
  Model model(mesh, orthotropic_cloth());
  const std::uint64_t before = model.hash();
  const MassChange change = model.apply(mesh, {});
  EXPECT_TRUE(change.vertices.empty());
  EXPECT_EQ(model.hash(), before);
}

TEST(Transfer, ConservesLinearMomentumAndCopiesDuplicatesBitForBit) {
  mesh::TriangleMesh mesh = jittered_square(12);
  Model model(mesh, orthotropic_cloth());
  RandomEdits edits(23);
  SeededRandom random(4);
  State state = rest_state(mesh);
  int num_duplicates = 0;
  for (int i = 0; i < 200; ++i) {
    state.x += random_field(random, state.x.cols(), 1e-3);
    state.v = random_field(random, state.v.cols(), 2.0);
    const Momentum before = model.momentum(state);
    const linear::VertexField x_before = state.x;
    const mesh::MeshEdit edit = edits.next(mesh);
    const MassChange change = model.apply(mesh, edit);
    transfer_state(edit, model, change, state);
    ASSERT_EQ(state.x.cols(), mesh.num_vertices());
    EXPECT_LT((model.momentum(state).linear - before.linear).norm(), 1e-13 * 2.0 * model.masses().total());
    for (const mesh::VertexSource& source : edit.added_vertices) {
      if (source.weights[0] != 1.0) continue;
      ++num_duplicates;
      EXPECT_EQ(state.x.col(source.vertex), x_before.col(source.sources[0]));
      if (!edit.moved_vertices.empty()) continue;
      EXPECT_EQ(state.v.col(source.vertex), state.v.col(source.sources[0]));
    }
  }
  EXPECT_GT(num_duplicates, 20);
}

TEST(Transfer, APureCutMovesNothingAndChangesNoVelocity) {
  mesh::TriangleMesh mesh = square_grid(6);
  Model model(mesh, orthotropic_cloth());
  State state = rest_state(mesh);
  SeededRandom random(9);
  state.v = random_field(random, state.v.cols(), 1.0);
  const State before = state;
  mesh::MeshEditor editor(mesh);
  // A straight cut along grid edges from the border inwards: edges (14, 15), (15, 16), then out to nowhere.
  for (const mesh::VertexId v : {12, 13, 14}) {
    int corner = 0;
    const mesh::TriangleId slot = mesh.find_edge(mesh.point(v), mesh.point(v + 1), corner);
    ASSERT_NE(slot, mesh::kNone);
    ASSERT_TRUE(editor.lock_edge(slot, corner, mesh::kLockCut));
  }
  const mesh::MeshEdit edit = editor.commit().edit;
  ASSERT_EQ(edit.added_vertices.size(), 3U);  // 12, 13, 14 are doubled, 15 is the tip
  const MassChange change = model.apply(mesh, edit);
  transfer_state(edit, model, change, state);
  EXPECT_EQ(state.x.leftCols(36), before.x);
  EXPECT_THAT(state.v.leftCols(36), test::MatrixNear(before.v, 1e-14));
  EXPECT_LT(
      (model.momentum(state).angular - Model(square_grid(6), orthotropic_cloth()).momentum(before).angular).norm(),
      1e-13);
}

}  // namespace
}  // namespace kerf::fem
