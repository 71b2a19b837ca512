#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/cut/curve.h"

// A drawing as its reader found it: shapes with all that can choose among them.
namespace kerf::drawing {

// Most segments that a reader keeps of a drawing, before anything is chosen.
inline constexpr std::size_t kMaxSegments = 100'000;
inline constexpr int kNoGroup = -1;

// A selector that names all shapes of a group and of the groups in it, such as "layer=Cut", ".hole" or "#frame".
struct Group {
  std::string selector;
  int parent = kNoGroup;  // Index of the next selector for the same shapes.
};

struct Shape {
  std::string name;                     // Names its element or entity, for messages.
  std::vector<cut::Subpath> lines;      // m, in the frame of the drawing; without arcs.
  bool is_painted = true;               // False: hidden, or painting nothing.
  std::optional<std::uint32_t> stroke;  // 0xrrggbb
  std::optional<std::uint32_t> fill;    // 0xrrggbb
  int group = kNoGroup;                 // Index of the first selector that names the shape.
};

struct Drawing {
  std::string format;         // "SVG" or "DXF AC1027", for example.
  std::vector<Shape> shapes;  // In the order of the drawing.
  std::vector<Group> groups;
  // The page at true size, m, y up. Absent: the drawing has none.
  std::optional<cut::Box> page;
  // Its own origin has a meaning without a page, as in DXF.
  bool has_origin = false;
  // Lists the parts of the drawing that are not in the shapes, by kind with counts, as text for users.
  std::vector<std::string> not_cut;
};

// A line whose end is to stay as it is, such as a dash's, has a straight piece of no length there.
void keep_ends(cut::Subpath& line, bool start, bool end);

}  // namespace kerf::drawing
