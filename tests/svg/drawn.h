#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "server/service/drawing/placing.h"
#include "server/service/svg/svg.h"

// Documents of tests, and what is cut of them.
namespace kerf::svg {

inline constexpr double kPixel = 0.0254 / 96.0;

struct Drawing {
  cut::Path path;
  std::vector<std::string> not_cut;
};

inline std::string document(const std::string& content,
                            const std::string& attributes = R"svg(width="100" height="100")svg") {
  return R"svg(<?xml version="1.0"?><svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" )svg" +
         attributes + ">" + content + "</svg>";
}

// Reads a drawing and chooses what is cut of it.
inline Result<Drawing> read_all(std::string_view data, const drawing::Reading& reading = {}) {
  KERF_TRY_ASSIGN(const drawing::Drawing read, svg::read(data, {reading.unit, reading.dashes}));
  KERF_TRY_ASSIGN(drawing::Placed placed, drawing::place(read, reading, "SVG", "cut.curve.svg"));
  return Drawing{std::move(placed.path), std::move(placed.notes)};
}

inline Drawing drawn(const std::string& text, const drawing::Reading& reading = {}) {
  Result<Drawing> drawing = read_all(text, reading);
  EXPECT_TRUE(drawing.ok()) << text << "\n" << drawing.error().message;
  return drawing.ok() ? *drawing : Drawing{};
}

}  // namespace kerf::svg
