#pragma once

#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/service/drawing/drawing.h"

namespace kerf::drawing {

inline constexpr std::size_t kMaxSelectors = 64;

// Chooses shapes by their colours, and by the layers, classes and ids of themselves and of the groups they are in.
class Selection {
 public:
  // Parses `stroke=COLOUR`, `fill=COLOUR`, `layer=NAME`, `.CLASS` and `#ID`. No selector chooses every shape. Errors,
  // field `field`.only[i]: kInvalidArgument SELECTOR_MALFORMED, TOO_MANY.
  static Result<Selection> parse(const std::vector<std::string>& selectors, const std::string& field);

  // Returns for each shape whether it is chosen. Error: kInvalidArgument SELECTOR_UNMATCHED if a selector names no
  // shape; the message lists what there is.
  [[nodiscard]] Result<std::vector<bool>> choose(const Drawing& drawing) const;

 private:
  std::vector<std::string> wanted_;  // Selectors as shapes have them.
  std::string field_;
};

}  // namespace kerf::drawing
