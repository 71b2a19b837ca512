#include "tests/bench/random_cuts_scene.h"

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>

#include "tests/bench/scenes.h"
#include "tests/bench/stage_clock.h"
#include "tests/support/random_cuts.h"

namespace kerf::bench {

sheet::Sheet cloth_to_cut(const fem::Material& material, CutScene scene) {
  scene::SheetConfig config = horizontal_cloth(50, scene::IntegratorKind::kExplicitLeapfrog);
  config.material = material;
  config.integrator.max_substeps = 100'000;
  if (scene == CutScene::kHung) config.pins.emplace_back(scene::RegionEdge::kTop);
  return create(scene == CutScene::kBall ? above_ball(std::move(config)) : std::move(config));
}

CutTime RandomCutter::cut(sheet::Sheet& sheet) {
  for (;;) {
    scene::Cut cut;
    cut.curve = test::random_cubic(random_);
    const scene::Command command = cut;
    StageClock clock;
    const sheet::TickReport report = sheet.apply({&command, 1}, &clock);
    const Result<scene::CommandReply>& reply = report.replies.front();
    if (!reply.ok() || reply->cut->status != cut::CutStatus::kApplied) continue;
    CutTime time{clock.spent(sheet::Stage::kCut), clock.spent(sheet::Stage::kModelUpdate), 0.0};
    for (const auto& [phase, spent] : clock.phases()) {
      if (std::string_view(phase) == "integrator") time.integrator += spent;
    }
    return time;
  }
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace kerf::bench
