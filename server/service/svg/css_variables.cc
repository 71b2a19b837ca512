#include "server/service/svg/css_variables.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include "server/service/svg/css.h"
#include "server/service/svg/css_scanner.h"

namespace kerf::svg {
namespace {

constexpr std::string_view kCall = "var(";
constexpr int kMaxReferences = 16;        // References that lead to each other.
constexpr std::size_t kMaxCalls = 1'000;  // Resolved for one value.

// Returns where var( begins; npos if it does not.
std::size_t find_call(std::string_view value) {
  const std::string text = lower(value);
  for (std::size_t at = text.find(kCall); at != std::string::npos; at = text.find(kCall, at + 1)) {
    const char before = at == 0 ? ' ' : text[at - 1];
    const bool is_name =
        (before >= 'a' && before <= 'z') || (before >= '0' && before <= '9') || before == '-' || before == '_';
    if (!is_name) return at;
  }
  return std::string::npos;
}

class Resolver {
 public:
  // Finds the value of a variable, with or without var() in it.
  using Find = std::function<const std::string*(const std::string&)>;
  Resolver(Find find, std::size_t& steps) : find_(std::move(find)), steps_(steps) {}

  std::optional<std::string> resolved(std::string_view value, int depth = 0) {
    std::string result;
    while (true) {
      const std::size_t at = find_call(value);
      steps_ += 1 + value.size() / 32;
      result += value.substr(0, at);
      if (result.size() > kMaxCssValue) return std::nullopt;
      if (at == std::string_view::npos) return result;
      if (depth > kMaxReferences || ++calls_ > kMaxCalls) return std::nullopt;
      value.remove_prefix(at + kCall.size());
      CssScanner scanner(value);
      const std::string_view inside = scanner.until(")");
      value.remove_prefix(std::min(inside.size() + 1, value.size()));
      const std::optional<std::string> part = part_of(inside, depth);
      if (!part) return std::nullopt;
      result += *part;
    }
  }

 private:
  // Returns what stands for var() with the given arguments.
  std::optional<std::string> part_of(std::string_view arguments, int depth) {
    CssScanner scanner(arguments);
    scanner.skip_blanks();
    const std::string name = scanner.identifier();
    scanner.skip_blanks();
    const bool has_fallback = scanner.accept(',');
    if (const std::string* const found = find_(name)) {
      if (std::optional<std::string> value = resolved(*found, depth + 1)) return value;
    }
    if (!has_fallback) return std::nullopt;
    return resolved(scanner.until(""), depth + 1);
  }

  Find find_;
  std::size_t& steps_;
  std::size_t calls_ = 0;
};

}  // namespace

const std::string* Variables::find(const std::string& name) const {
  for (const Variables* each = this; each != nullptr; each = each->around.get()) {
    const auto found = each->own.find(name);
    if (found != each->own.end()) return found->second.empty() ? nullptr : &found->second;
  }
  return nullptr;
}

std::shared_ptr<const Variables> variables_within(const std::shared_ptr<const Variables>& around,
                                                  const CustomProperties& own, std::size_t& steps) {
  if (own.empty()) return around;
  auto variables = std::make_shared<Variables>();
  variables->around = around;
  const auto find = [&](const std::string& name) -> const std::string* {
    const auto found = own.find(name);
    if (found != own.end()) return &found->second;
    return around ? around->find(name) : nullptr;
  };
  for (const auto& [name, value] : own) {
    const std::string keyword = lower(value);
    if (keyword == "inherit" || keyword == "unset") continue;
    const bool is_invalid = keyword == "initial";
    variables->own[name] = is_invalid ? std::string() : Resolver(find, steps).resolved(value).value_or("");
  }
  return variables;
}

bool replace_variables(std::string& value, const Variables* variables, std::size_t& steps) {
  if (find_call(value) == std::string::npos) return true;
  const auto find = [variables](const std::string& name) {
    return variables == nullptr ? nullptr : variables->find(name);
  };
  std::optional<std::string> resolved = Resolver(find, steps).resolved(value);
  value = resolved ? std::move(*resolved) : std::string();
  return resolved.has_value();
}

}  // namespace kerf::svg
