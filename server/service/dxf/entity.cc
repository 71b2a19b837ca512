#include "server/service/dxf/entity.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "server/service/dxf/colours.h"

namespace kerf::dxf {
namespace {

constexpr const char* kField = "cut.curve.dxf";
constexpr int kFrozen = 1;

std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

// Takes the next line of the text, whatever its end: also CR CR LF, which two conversions of line ends make.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = text.find_first_of("\r\n");
  const std::string_view line = text.substr(0, end);
  if (end == std::string_view::npos) {
    text = {};
  } else {
    const bool is_doubled = text.substr(end, 3) == "\r\r\n";
    text.remove_prefix(end + (is_doubled ? 3 : text.substr(end, 2) == "\r\n" ? 2 : 1));
  }
  return line;
}

// True for codes whose values are numbers.
bool is_numeric(int code) {
  return (code >= 10 && code < 80) || (code >= 90 && code < 100) || (code >= 140 && code < 180) ||
         (code >= 210 && code < 240) || (code >= 270 && code < 300) || (code >= 370 && code < 390) ||
         (code >= 400 && code < 410) || (code >= 420 && code < 430);
}

// Divides the groups from `first` on into entities, up to one of type `end`; returns the group after it.
const Group* entities_until(std::string_view end, const Group* first, const Group* last,
                            std::vector<Entity>& entities) {
  while (first != last) {
    const Group* const from = first++;
    while (first != last && first->code != 0) ++first;
    if (from->code != 0) continue;
    if (from->value == end) return first;
    entities.push_back({from->value, from->line, from + 1, first});
  }
  return first;
}

Layer layer_of(const Entity& entry) {
  const int colour = entry.integer(62, 7);
  Layer layer;
  layer.is_off = colour < 0;
  layer.is_frozen = (entry.integer(70, 0) & kFrozen) != 0;
  layer.colour = indexed_colour(std::abs(colour));
  if (entry.has(420)) layer.colour = static_cast<std::uint32_t>(entry.integer(420, 0)) & 0xffffffU;
  const std::string type = key_of(entry.text(6));
  layer.is_dashed = !type.empty() && type != "CONTINUOUS";
  return layer;
}

void read_header(const Group* first, const Group* last, File& file) {
  for (; first != last; ++first) {
    if (first->code != 9 || first + 1 == last) continue;
    const std::string_view value = first[1].value;
    if (first->value == "$ACADVER") file.version = std::string(value);
    if (first->value == "$MEASUREMENT") file.measurement = static_cast<int>(to_number(value).value_or(1.0));
    if (first->value == "$INSUNITS") file.units = static_cast<int>(to_number(value).value_or(0.0));
  }
}

void read_blocks(const std::vector<Entity>& entities, File& file) {
  Block* open = nullptr;
  for (const Entity& entity : entities) {
    if (entity.type == "BLOCK") {
      open = &file.blocks[key_of(entity.text(2))];
      open->base = entity.point(10);
    } else if (entity.type == "ENDBLK") {
      open = nullptr;
    } else if (open != nullptr) {
      open->entities.push_back(entity);
    }
  }
}

Error cut_off(int line, const std::string& section) {
  return malformed(line, "the file ends here, within the section " + section + ": it was not saved or copied whole");
}

}  // namespace

Error malformed(int line, const std::string& why) {
  return invalid_argument("DXF_MALFORMED", "line " + std::to_string(line) + " of the drawing: " + why, kField);
}

std::optional<double> to_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  // Programs in Fortran write 1.5D+01 for 15.
  const std::size_t exponent = text.find_first_of("dD");
  std::string with_e;
  if (exponent != std::string_view::npos) {
    with_e = text;
    with_e[exponent] = 'e';
    text = with_e;
  }
  double value = 0.0;
  const auto [stop, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc() || stop != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

double Entity::number(int code, double otherwise) const {
  const Group* const found = std::find_if(first, last, [code](const Group& group) { return group.code == code; });
  return found == last ? otherwise : to_number(found->value).value_or(otherwise);
}

int Entity::integer(int code, int otherwise) const {
  const double value = number(code, otherwise);
  return static_cast<int>(std::clamp(value, -2.0e9, 2.0e9));
}

std::string_view Entity::text(int code) const {
  const Group* const found = std::find_if(first, last, [code](const Group& group) { return group.code == code; });
  return found == last ? std::string_view() : found->value;
}

bool Entity::has(int code) const {
  return std::any_of(first, last, [code](const Group& group) { return group.code == code; });
}

Eigen::Vector2d Entity::point(int code) const {
  return {number(code, 0.0), number(code + 10, 0.0)};
}

Result<std::vector<Group>> groups_of(std::string_view text) {
  std::vector<Group> groups;
  int line = 0;
  while (text.find_first_of("\r\n") == text.find_first_not_of(" \t") && !text.empty()) {  // blank lines at the start
    take_line(text);
    ++line;
  }
  while (!text.empty()) {
    const std::string_view code = without_blanks(take_line(text));
    ++line;
    if (code.empty() && without_blanks(text).empty()) break;
    const std::optional<double> number = to_number(code);
    if (!number || *number < -100.0 || *number > 2'000.0 || *number != static_cast<int>(*number)) {
      return malformed(line, "'" + std::string(code.substr(0, 40)) + "' is no group code");
    }
    if (text.empty()) return malformed(line, "the file ends after a group code");
    Group group{static_cast<int>(*number), without_blanks(take_line(text)), ++line};
    if (is_numeric(group.code) && !to_number(group.value)) {
      return malformed(line, "'" + std::string(group.value.substr(0, 40)) + "' is no number");
    }
    if (group.code == 0 && group.value == "EOF") break;
    if (group.code != 999) groups.push_back(group);
  }
  return groups;
}

Result<File> divided(const std::vector<Group>& groups) {
  File file;
  bool has_entities = false;
  const Group* at = groups.data();
  const Group* const end = at + groups.size();
  while (at != end) {
    const bool begins = at->code == 0 && at->value == "SECTION" && at + 1 != end && at[1].code == 2;
    if (!begins) {
      ++at;
      continue;
    }
    const std::string_view name = at[1].value;
    const Group* const first = at + 2;
    std::vector<Entity> entities;
    at = entities_until("ENDSEC", first, end, entities);
    const bool is_whole = at != first && at[-1].code == 0 && at[-1].value == "ENDSEC";
    if (name == "HEADER") read_header(first, at, file);
    if (name == "TABLES") {
      for (const Entity& entry : entities) {
        if (entry.type == "LAYER") file.layers[key_of(entry.text(2))] = layer_of(entry);
      }
    }
    if (name == "BLOCKS" && !is_whole) return cut_off(groups.back().line, "BLOCKS");
    if (name == "BLOCKS") read_blocks(entities, file);
    if (name == "ENTITIES") {
      if (!is_whole) return cut_off(groups.back().line, "ENTITIES");
      has_entities = true;
      file.entities = std::move(entities);
    }
  }
  if (!has_entities) {
    return invalid_argument("DXF_MALFORMED", "the file has no section ENTITIES: it is no DXF drawing", kField);
  }
  return file;
}

std::string name_of(std::string_view name) {
  std::string result;
  while (!name.empty()) {
    unsigned code = 0;
    if (name.size() >= 7 && name.substr(0, 3) == "\\U+") {
      const auto [stop, fault] = std::from_chars(name.data() + 3, name.data() + 7, code, 16);
      if (fault != std::errc() || stop != name.data() + 7 || (code >= 0xd800 && code < 0xe000)) code = 0;
    }
    if (code == 0) {
      result += name.front();
      name.remove_prefix(1);
      continue;
    }
    name.remove_prefix(7);
    if (code < 0x80) {
      result += static_cast<char>(code);
    } else if (code < 0x800) {
      result += static_cast<char>(0xc0U | code >> 6U);
      result += static_cast<char>(0x80U | (code & 0x3fU));
    } else {
      result += static_cast<char>(0xe0U | code >> 12U);
      result += static_cast<char>(0x80U | (code >> 6U & 0x3fU));
      result += static_cast<char>(0x80U | (code & 0x3fU));
    }
  }
  return result;
}

std::string key_of(std::string_view name) {
  std::string key = name_of(name);
  for (char& c : key) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return key;
}

}  // namespace kerf::dxf
