#include "server/service/drawing/selector.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "server/service/drawing/colour.h"

namespace kerf::drawing {
namespace {

constexpr std::size_t kMaxListed = 40;  // Selectors that an error lists.

bool begins(std::string_view text, std::string_view with) {
  return text.substr(0, with.size()) == with;
}

// Returns the selector as shapes have it; empty if it is malformed.
std::string normalised(const std::string& selector) {
  for (const char* paint : {"stroke=", "fill="}) {
    if (!begins(selector, paint)) continue;
    const std::optional<Colour> colour =
        parse_colour(std::string_view(selector).substr(std::string_view(paint).size()));
    return colour ? paint + name_of_colour(colour->rgb) : std::string();
  }
  if (begins(selector, "layer=") && selector.size() > 6) return selector;
  if ((begins(selector, ".") || begins(selector, "#")) && selector.size() > 1) return selector;
  return {};
}

// Marks the groups that have shapes, with those around them.
std::vector<bool> used_groups(const Drawing& drawing) {
  std::vector<bool> is_used(drawing.groups.size(), false);
  for (const Shape& shape : drawing.shapes) {
    for (int at = shape.group; at != kNoGroup && !is_used[static_cast<std::size_t>(at)];
         at = drawing.groups[static_cast<std::size_t>(at)].parent) {
      is_used[static_cast<std::size_t>(at)] = true;
    }
  }
  return is_used;
}

std::set<std::string> all_selectors(const Drawing& drawing) {
  std::set<std::string> all;
  const std::vector<bool> is_used = used_groups(drawing);
  for (std::size_t i = 0; i < drawing.groups.size(); ++i) {
    if (is_used[i]) all.insert(drawing.groups[i].selector);
  }
  for (const Shape& shape : drawing.shapes) {
    if (shape.stroke) all.insert("stroke=" + name_of_colour(*shape.stroke));
    if (shape.fill) all.insert("fill=" + name_of_colour(*shape.fill));
  }
  return all;
}

std::string list_of_all(const Drawing& drawing) {
  const std::set<std::string> all = all_selectors(drawing);
  if (all.empty()) return "no colour, layer, class or id";
  std::string text;
  std::size_t listed = 0;
  for (const std::string& selector : all) {
    if (++listed > kMaxListed) return text + " and " + std::to_string(all.size() - kMaxListed) + " more";
    text += (text.empty() ? "" : ", ") + selector;
  }
  return text;
}

}  // namespace

Result<Selection> Selection::parse(const std::vector<std::string>& selectors, const std::string& field) {
  Selection selection;
  selection.field_ = field;
  if (selectors.size() > kMaxSelectors) {
    return invalid_argument("TOO_MANY", std::to_string(selectors.size()) + " selectors; the limit is 64",
                            field + ".only");
  }
  for (std::size_t i = 0; i < selectors.size(); ++i) {
    std::string selector = normalised(selectors[i]);
    if (selector.empty()) {
      return invalid_argument(
          "SELECTOR_MALFORMED",
          "'" + selectors[i] + "' chooses nothing: give stroke=COLOUR, fill=COLOUR, layer=NAME, .CLASS or #ID",
          field + ".only[" + std::to_string(i) + "]");
    }
    selection.wanted_.push_back(std::move(selector));
  }
  return selection;
}

Result<std::vector<bool>> Selection::choose(const Drawing& drawing) const {
  std::vector<bool> chosen(drawing.shapes.size(), wanted_.empty());
  if (wanted_.empty()) return chosen;
  std::vector<bool> is_met(wanted_.size(), false);
  const auto meet = [&](std::string_view selector) {
    bool any = false;
    for (std::size_t i = 0; i < wanted_.size(); ++i) {
      if (wanted_[i] != selector) continue;
      is_met[i] = any = true;
    }
    return any;
  };
  // A group is compared once, however many shapes are in it. Parents come before the groups in them.
  std::vector<bool> is_wanted(drawing.groups.size(), false);
  const std::vector<bool> is_used = used_groups(drawing);
  for (std::size_t i = 0; i < drawing.groups.size(); ++i) {
    const Group& group = drawing.groups[i];
    const bool inherited = group.parent != kNoGroup && is_wanted[static_cast<std::size_t>(group.parent)];
    is_wanted[i] = (is_used[i] && meet(group.selector)) || inherited;
  }
  for (std::size_t i = 0; i < drawing.shapes.size(); ++i) {
    const Shape& shape = drawing.shapes[i];
    const bool by_stroke = shape.stroke && meet("stroke=" + name_of_colour(*shape.stroke));
    const bool by_fill = shape.fill && meet("fill=" + name_of_colour(*shape.fill));
    const bool by_group = shape.group != kNoGroup && is_wanted[static_cast<std::size_t>(shape.group)];
    chosen[i] = by_stroke || by_fill || by_group;
  }
  const auto unmet = std::find(is_met.begin(), is_met.end(), false);
  if (unmet == is_met.end()) return chosen;
  const auto index = static_cast<std::size_t>(unmet - is_met.begin());
  return invalid_argument("SELECTOR_UNMATCHED",
                          "nothing in the drawing is " + wanted_[index] + "; it has " + list_of_all(drawing),
                          field_ + ".only[" + std::to_string(index) + "]");
}

}  // namespace kerf::drawing
