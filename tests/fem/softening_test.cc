// Softening of a membrane so that explicit steps fit their tick.
#include "server/core/fem/step/softening.h"

#include "server/core/fem/step/automatic_integrator.h"
#include "server/core/mesh/regions.h"
#include "tests/fem/fixture.h"

namespace kerf::fem {
namespace {

constexpr double kGravity = 9.81;  // m/s^2

IntegratorOptions options_of_kind(IntegratorKind kind) {
  IntegratorOptions options;
  options.kind = kind;
  return options;
}

Material known_material(std::string_view name) {
  return find_preset(name).value();
}

// Its moduli times as large, and its bending as it was.
Material with_moduli_times(Material material, double times) {
  material.youngs_modulus_1 *= times;
  material.youngs_modulus_2 *= times;
  material.shear_modulus *= times;
  material.bending_scale /= times;
  return material;
}

Softening choose_for(const mesh::TriangleMesh& mesh, const Material& material, IntegratorKind kind) {
  return choose_softening(mesh, std::span(&material, 1), MembraneLaw::kCorotational, options_of_kind(kind), kGravity);
}

TEST(Softening, KeepsBendingToTheBit) {
  std::vector<Material> materials{orthotropic_cloth()};
  for (const std::string_view name : preset_names()) materials.push_back(known_material(name));
  materials.push_back(known_material("wool"));
  materials.back().bending_stiffness_1 = 1.0e-4;  // as if measured
  materials.back().twisting_stiffness = 3.0e-5;
  for (const Material& material : materials) {
    for (const int factor : {1, 2, 4, 8, 16}) {
      const Material soft = soften(material, factor);
      EXPECT_EQ(bending_law(soft), bending_law(material)) << factor;
      EXPECT_EQ(membrane_law(soft) * factor, membrane_law(material)) << factor;
      EXPECT_EQ(soft.density, material.density);
    }
  }
}

TEST(Softening, LeavesAloneWhatFits) {
  const Softening choice = choose_for(square_grid(50), known_material("demo"), IntegratorKind::kAutomatic);
  EXPECT_EQ(choice.factor, 1);
  EXPECT_TRUE(choice.fits());
  EXPECT_EQ(choice.expected_error, 0.0);
  EXPECT_NE(describe(choice).find("membrane as given"), std::string::npos);
}

TEST(Softening, TakesTheLeastFactorThatFits) {
  const mesh::TriangleMesh mesh = square_grid(13);
  const IntegratorOptions options = options_of_kind(IntegratorKind::kExplicit);
  int before = 1;
  for (double times = 1.0; times < 1e5; times *= 2.0) {
    const Material material = with_moduli_times(known_material("wool"), times);
    const Softening choice = choose_for(mesh, material, IntegratorKind::kExplicit);
    const auto cost = [&](int factor) {
      return 1e-9 * estimate_tick(Model(mesh, soften(material, factor)), options).explicit_ns;
    };
    EXPECT_EQ(choice.cost, cost(choice.factor));
    EXPECT_TRUE(choice.fits() || choice.factor == 16) << times;
    if (choice.factor > 1) {
      EXPECT_GT(cost(choice.factor / 2), choice.budget) << times;
    }
    EXPECT_GE(choice.factor, before) << times;
    before = choice.factor;
  }
  EXPECT_EQ(before, 16);
}

TEST(Softening, GrowsWithTheNumberOfVertices) {
  std::vector<int> factors;
  for (const int n : {25, 38, 42, 45, 50}) {
    factors.push_back(choose_for(square_grid(n), known_material("wool"), IntegratorKind::kAutomatic).factor);
  }
  EXPECT_EQ(factors, (std::vector{1, 2, 4, 8, 16}));
}

TEST(Softening, SaysWhereEvenTheMostDoesNotFit) {
  const Softening choice =
      choose_for(square_grid(20), with_moduli_times(known_material("wool"), 1e4), IntegratorKind::kExplicit);
  EXPECT_EQ(choice.factor, 16);
  EXPECT_FALSE(choice.fits());
  EXPECT_NE(describe(choice).find("16 times softer"), std::string::npos);
  EXPECT_NE(describe(choice).find("still does not fit"), std::string::npos);
}

TEST(Softening, DoesNothingForImplicitSteps) {
  const Material stiff = with_moduli_times(known_material("wool"), 1e5);
  for (const IntegratorKind kind : {IntegratorKind::kAutomatic, IntegratorKind::kTrBdf2}) {
    const Softening choice = choose_for(square_grid(13), stiff, kind);
    EXPECT_EQ(choice.factor, 1);
    EXPECT_FALSE(choice.is_explicit);
    EXPECT_EQ(choice.expected_error, 0.0);
    EXPECT_NE(describe(choice).find("implicit steps"), std::string::npos);
  }
}

TEST(Softening, FollowsTheStiffestOfSeveralMaterials) {
  mesh::TriangleMesh mesh = square_grid(50);
  std::vector<std::int32_t> regions(static_cast<std::size_t>(mesh.num_triangle_slots()), 0);
  for (std::size_t i = 0; i < regions.size() / 2; ++i) regions[i] = 1;
  mesh = mesh::with_regions(mesh, regions);
  const std::vector<Material> materials{known_material("demo"), known_material("wool")};
  const Softening choice = choose_softening(mesh, materials, MembraneLaw::kCorotational,
                                            options_of_kind(IntegratorKind::kExplicit), kGravity);
  EXPECT_EQ(choice.factor, 16);
}

TEST(Softening, ExpectsMoreErrorOfLargerAndSofterSheets) {
  const std::vector<Material> wool{known_material("wool")};
  const std::vector<Material> demo{known_material("demo")};
  EXPECT_EQ(expected_error(1, demo, 1.0, kGravity), 0.0);
  EXPECT_NEAR(expected_error(16, wool, 1.0, 0.0), 2.0e-3, 1e-12);
  EXPECT_GT(expected_error(16, wool, 2.0, kGravity), 2.0 * expected_error(16, wool, 1.0, kGravity));
  EXPECT_NEAR(expected_error(2, demo, 1.0, kGravity), 0.8e-3 + 0.2 * kGravity / 200.0, 1e-9);
}

}  // namespace
}  // namespace kerf::fem
