#include "server/service/svg/layer_names.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "server/service/svg/css_match.h"

namespace kerf::svg {
namespace {

// Decodes an id of Illustrator: "Cut_x5F_1_lines" was "Cut_1 lines".
std::string decoded_id(std::string_view id) {
  std::string name;
  while (!id.empty()) {
    const std::size_t end = id.size() > 3 && id.substr(0, 2) == "_x" ? id.find('_', 2) : std::string_view::npos;
    unsigned code = 0;
    if (end != std::string_view::npos && end <= 6) {
      const auto [stop, fault] = std::from_chars(id.data() + 2, id.data() + end, code, 16);
      if (fault != std::errc() || stop != id.data() + end || code >= 0x80) code = 0;
    }
    if (code != 0) {
      name += static_cast<char>(code);
      id.remove_prefix(end + 1);
    } else {
      name += id.front() == '_' ? ' ' : id.front();
      id.remove_prefix(1);
    }
  }
  return name;
}

}  // namespace

bool is_inkscape_layer(const pugi::xml_node& node) {
  return std::string_view(node.attribute("inkscape:groupmode").value()) == "layer";
}

std::vector<std::string> layer_names(const pugi::xml_node& node, const pugi::xml_node& root, bool has_inkscape_layers) {
  const std::string id = node.attribute("id").value();
  std::vector<std::string> names;
  if (has_inkscape_layers) {
    if (!is_inkscape_layer(node)) return {};
    const std::string label = node.attribute("inkscape:label").value();
    names = {label.empty() ? id : label};
  } else {
    if (node.parent() != root || local_name(node) != "g") return {};
    names = {node.attribute("data-name").value(), id, decoded_id(id)};
  }
  std::vector<std::string> distinct;
  for (const std::string& name : names) {
    if (name.empty() || std::find(distinct.begin(), distinct.end(), name) != distinct.end()) continue;
    distinct.push_back(name);
  }
  return distinct;
}

}  // namespace kerf::svg
