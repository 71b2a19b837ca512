#include "server/core/mesh/build/mesh_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <unordered_map>

#include "server/base/interruption.h"

namespace kerf::mesh {
namespace {

constexpr std::size_t kMaxNamedFaces = 5;

std::string numbered(std::int64_t number, std::int32_t line) {
  return std::to_string(number) + (line > 0 ? " (line " + std::to_string(line) + ")" : "");
}

}  // namespace

std::string MeshFile::face_name(std::size_t face) const {
  return "face " + numbered(static_cast<std::int64_t>(face) + first_number, faces[face].line);
}

std::string MeshFile::vertex_name(std::size_t position) const {
  const std::int32_t line = position_lines.empty() ? 0 : position_lines[position];
  return "vertex " + numbered(static_cast<std::int64_t>(position) + first_number, line);
}

std::string MeshFile::face_names(std::span<const std::int32_t> some) const {
  if (some.size() == 1) return face_name(static_cast<std::size_t>(some[0]));
  const std::size_t num_named = some.size() > kMaxNamedFaces ? kMaxNamedFaces - 2 : some.size();
  std::string text = "faces ";
  for (std::size_t i = 0; i < num_named; ++i) {
    const bool is_last = i + 1 == some.size();
    text += (i == 0 ? "" : is_last ? " and " : ", ") + numbered(some[i] + first_number, faces[some[i]].line);
  }
  return num_named < some.size() ? text + " and " + std::to_string(some.size() - num_named) + " more" : text;
}

Error MeshFile::refuse(const std::string& reason, const std::string& message, std::int64_t line) const {
  std::string field = kind;
  std::transform(field.begin(), field.end(), field.begin(), [](char c) { return static_cast<char>(c + ('a' - 'A')); });
  if (line <= 0) return invalid_argument(kind + "_" + reason, message, field);
  const std::string number = std::to_string(line);
  return invalid_argument(kind + "_" + reason, "line " + number + ": " + message, field + ":" + number);
}

Error MeshFile::refuse_vertex(const std::string& reason, const std::string& message, std::size_t position) const {
  Error error = refuse(reason, message);
  error.field += position_lines.empty() ? ":vertex[" + std::to_string(position) + "]"
                                        : ":" + std::to_string(position_lines[position]);
  return error;
}

std::vector<std::pair<std::string, std::int32_t>> MeshFile::object_sizes() const {
  std::vector<std::int32_t> faces_of(parts.size(), 0);
  for (const MeshFile::Face& face : faces) ++faces_of[static_cast<std::size_t>(face.part)];
  std::vector<std::pair<std::string, std::int32_t>> sizes;
  std::unordered_map<std::string_view, std::size_t> index_of;  // in sizes, by a name of parts
  const auto count = [&](const std::string& name, std::int32_t num_faces) {
    interruption_point();
    if (name.empty() || num_faces == 0) return;
    const auto [found, is_new] = index_of.try_emplace(name, sizes.size());
    if (is_new) sizes.emplace_back(name, 0);
    sizes[found->second].second += num_faces;
  };
  for (std::size_t p = 0; p < parts.size(); ++p) {
    count(parts[p].object, faces_of[p]);
    for (const std::string& group : parts[p].groups) {
      if (group != parts[p].object) count(group, faces_of[p]);
    }
  }
  return sizes;
}

void FaultList::add(Error fault) {
  ++num_;
  if (shown_.size() < kMaxShownFaults) shown_.push_back(std::move(fault));
}

std::vector<std::string> FaultList::lines() const {
  std::vector<std::string> lines;
  for (const Error& fault : shown_) lines.push_back(fault.message);
  if (num_ > shown_.size()) lines.push_back("and " + counted(num_ - shown_.size(), "more fault"));
  return lines;
}

Error FaultList::as_error(FaultList* all_faults) const {
  if (all_faults != nullptr) *all_faults = *this;
  Error error = shown_.front();
  const std::vector<std::string> all = lines();
  for (std::size_t i = 1; i < all.size(); ++i) error.message += "; " + all[i];
  return error;
}

std::string length_text(double metres) {
  struct Unit {
    double size;
    const char* name;
  };
  constexpr std::array<Unit, 4> kUnits{{{1.0, "m"}, {1e-3, "mm"}, {1e-6, "um"}, {1e-9, "nm"}}};
  const Unit* unit = kUnits.data();
  while (unit != &kUnits.back() && std::abs(metres) < 0.1 * unit->size) ++unit;
  std::array<char, 32> text{};
  if (metres == 0.0) return "0 m";
  const char* const format = std::abs(metres) < 1000.0 ? "%.3g %s" : "%.6g %s";
  std::snprintf(text.data(), text.size(), format, metres / unit->size, unit->name);
  return text.data();
}

std::string counted(std::size_t count, const std::string& noun) {
  if (count == 1) return "1 " + noun;
  const bool is_vertex = noun.ends_with("vertex");
  return std::to_string(count) + " " + (is_vertex ? noun.substr(0, noun.size() - 2) + "ices" : noun + "s");
}

}  // namespace kerf::mesh
