#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/fem/element/state.h"
#include "server/core/sheet/sheet.h"
#include "tests/property/random_curves.h"
#include "tests/property/random_sheets.h"

// Random sheets that move, and what looks at them.
namespace kerf::property {

using scene::Command;
using scene::Grab;
using scene::Release;
using scene::SheetConfig;
using sheet::Sheet;
using sheet::Topology;

// A viewer that is given patches only, as Topology's comment describes them.
struct PatchMirror {
  std::int32_t version = 0;
  std::vector<std::array<mesh::VertexId, 3>> triangles;
  std::vector<std::int32_t> pieces;
  Eigen::Matrix2Xd material_positions{2, 0};

  void follow(const Topology& now) {
    const std::int32_t since = version < now.patchable_since ? 0 : version;
    if (since == 0) *this = PatchMirror{};
    triangles.resize(now.triangles.size());
    pieces.resize(now.pieces.size());
    for (std::size_t s = 0; s < now.triangles.size(); ++s) {
      if (now.slot_versions[s] <= since) continue;
      triangles[s] = now.triangles[s];
      pieces[s] = now.pieces[s];
    }
    material_positions.conservativeResize(Eigen::NoChange, now.material_positions.cols());
    for (Eigen::Index v = 0; v < material_positions.cols(); ++v) {
      if (now.vertex_versions[static_cast<std::size_t>(v)] > since) {
        material_positions.col(v) = now.material_positions.col(v);
      }
    }
    version = now.version;
  }
};

inline SheetConfig random_config(SeededRandom& random, Frame& frame) {
  RandomArrays made = random_arrays(random);
  frame = made.frame;
  SheetConfig config;
  config.mesh = scene::ArraySource{std::move(made.arrays.rest), std::move(made.arrays.triangles),
                                   Eigen::Matrix3Xd(3, 0), std::move(made.arrays.surface)};
  config.material.youngs_modulus_2 *= random.uniform(0.5, 1.0);
  config.material.direction = random.uniform(0.0, 3.0);
  if (random.below(2) == 0) config.material.bending_scale = 0.0;
  if (random.below(4) == 0) config.pins = {std::vector<mesh::VertexId>{0}};
  config.gravity = {0.0, 0.0, -9.81 * frame.scale};
  config.wind = {std::min(frame.scale, 100.0) * Eigen::Vector3d(1.0, 3.0, -2.0), 1.2, 1.0};
  config.integrator.kind = scene::IntegratorKind::kExplicitLeapfrog;
  config.integrator.max_substeps = 4;  // the motion need not keep up, it only has to be there
  return config;
}

// The first random sheet that Kerf takes: one in some hundreds is beyond double precision, and rightly refused.
inline Result<Sheet> random_moving_sheet(SeededRandom& random, Frame& frame) {
  while (true) {
    Result<Sheet> made = Sheet::create(random_config(random, frame));
    if (made.ok() || made.error().reason != "SHEET_TOO_STIFF") return made;
  }
}

// Pulls a vertex about, so that the sheet strains and turns.
inline void stir(SeededRandom& random, const Frame& frame, Sheet& sheet) {
  const mesh::VertexId vertex = random_vertex_id(random, sheet.mesh());
  const Eigen::Vector3d pull(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1));
  const std::vector<Command> grab{
      Grab{"hand", vertex, Eigen::Vector3d(sheet.state().x.col(vertex) + frame.scale * pull), 0.0}};
  const std::vector<Command> release{Release{"hand"}};
  sheet.step(grab);
  sheet.step({});
  sheet.step(release);
  ASSERT_FALSE(sheet.frozen());
}

}  // namespace kerf::property
