#pragma once

#include <nlohmann/json.hpp>

// Rows that figures 5.6 and 5.9 of the thesis are drawn from.
namespace kerf::evaluation {

// Figure 5.6: lips of one cut in a moving sheet, a row for each way to cut. Each has the triangles near the middle of
// the cut as they hang, seen from the side, [[x, y, x, y, x, y], ...], m, and the lips among their edges.
nlohmann::json lips_in_motion();

// Figure 5.9: curves of the growing cuts, a row for each family and some of its sizes, as [[[x, y], ...], ...], m.
nlohmann::json growing_curves();

}  // namespace kerf::evaluation
