#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"

namespace kerf::dxf {

// A group: a code and its value.
struct Group {
  int code = 0;
  std::string_view value;
  int line = 0;  // Number of the value's line, from 1.
};

// An entity, a vertex of one, or an entry of a table: its type and the groups after it.
struct Entity {
  std::string_view type;
  int line = 0;
  const Group* first = nullptr;
  const Group* last = nullptr;  // One past the end.

  // Return the first value of a code, or `otherwise`.
  [[nodiscard]] double number(int code, double otherwise) const;
  [[nodiscard]] int integer(int code, int otherwise) const;
  [[nodiscard]] std::string_view text(int code) const;
  [[nodiscard]] bool has(int code) const;
  // Returns the point with the codes `code` and `code` + 10.
  [[nodiscard]] Eigen::Vector2d point(int code) const;
};

struct Layer {
  bool is_off = false;     // Hides what lies on the layer itself.
  bool is_frozen = false;  // Hides all of an insertion on the layer, too.
  std::uint32_t colour = 0;
  bool is_dashed = false;
};

struct Block {
  Eigen::Vector2d base{0.0, 0.0};
  std::vector<Entity> entities;
};

// A file as it is divided.
struct File {
  std::string version;             // $ACADVER
  int units = 0;                   // $INSUNITS
  std::optional<int> measurement;  // $MEASUREMENT
  std::unordered_map<std::string, Layer> layers;
  std::unordered_map<std::string, Block> blocks;
  std::vector<Entity> entities;
};

// Parses a number of a group; nothing if it is none.
std::optional<double> to_number(std::string_view text);

// Divides the text into groups. `text` must outlive them. Errors: DXF_MALFORMED.
Result<std::vector<Group>> groups_of(std::string_view text);
// Divides the groups into sections and entities; both must outlive the result. Errors: DXF_MALFORMED.
Result<File> divided(const std::vector<Group>& groups);

// Returns a name as it is compared: in upper case, with \U+XXXX resolved.
std::string key_of(std::string_view name);
// Returns a name for people: with \U+XXXX resolved.
std::string name_of(std::string_view name);

Error malformed(int line, const std::string& why);

}  // namespace kerf::dxf
