#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

#include "kerf/v1/scene.pb.h"

namespace kerf::load {

// Chooses what the cuts of a run look like. kMixed takes the others in turn.
enum class CutKind { kSlit, kCurve, kCircle, kStar, kDrawing, kMixed };
inline constexpr std::array<std::pair<std::string_view, CutKind>, 6> kCutKinds{{{"slit", CutKind::kSlit},
                                                                                {"curve", CutKind::kCurve},
                                                                                {"circle", CutKind::kCircle},
                                                                                {"star", CutKind::kStar},
                                                                                {"drawing", CutKind::kDrawing},
                                                                                {"mixed", CutKind::kMixed}}};
[[nodiscard]] std::string_view name_of(CutKind kind);

// Places a cut on a sheet.
struct CutPlace {
  double x = 0.0;  // m, the middle of the cut.
  double y = 0.0;
  double angle = 0.0;   // rad
  double length = 0.0;  // m, > 0; the largest extent of the cut.
};

// Returns the cut number `k` of a run. Circles, stars and drawings cut pieces out.
[[nodiscard]] v1::Cut cut_of(CutKind kind, std::int64_t k, const CutPlace& place);

}  // namespace kerf::load
