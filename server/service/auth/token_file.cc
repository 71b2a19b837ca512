#include "server/service/auth/token_file.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>

namespace kerf::auth {
namespace {

constexpr std::string_view kPrefix = "kerf_";
constexpr std::size_t kMaxId = 32;
constexpr std::size_t kMaxPattern = 128;
constexpr std::size_t kSecretLength = 43;

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

bool is_id(std::string_view id) {
  return !id.empty() && id.size() <= kMaxId && is_plain(id.front()) &&
         std::all_of(id.begin(), id.end(), [](char c) { return is_plain(c) || c == '-'; });
}

bool is_pattern(std::string_view pattern) {
  return !pattern.empty() && pattern.size() <= kMaxPattern && std::all_of(pattern.begin(), pattern.end(), [](char c) {
    return is_plain(c) || c == '-' || c == '*' || c == '?';
  });
}

std::optional<int> number_in(std::string_view digits) {
  int number = 0;
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (fault != std::errc() || end != digits.data() + digits.size() || digits.front() == '-') return std::nullopt;
  return number;
}

// Returns the first second of a day, YYYY-MM-DD by UTC, in s since 1970.
std::optional<std::int64_t> day_in(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  const std::optional<int> year = number_in(text.substr(0, 4)), month = number_in(text.substr(5, 2)),
                           day = number_in(text.substr(8, 2));
  if (!year || !month || !day) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  if (!date.ok() || *year < 1971) return std::nullopt;
  return std::int64_t{86'400} * std::chrono::sys_days(date).time_since_epoch().count();
}

std::optional<Digest> digest_in(std::string_view hex) {
  Digest digest{};
  if (hex.size() != 2 * digest.size()) return std::nullopt;
  for (std::size_t i = 0; i < digest.size(); ++i) {
    const char* const first = hex.data() + 2 * i;
    const auto [end, fault] = std::from_chars(first, first + 2, digest[i], 16);
    if (fault != std::errc() || end != first + 2) return std::nullopt;
  }
  return digest;
}

std::vector<std::string_view> words_in(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r";
  std::vector<std::string_view> words;
  line = line.substr(0, line.find('#'));
  while (true) {
    const std::size_t begin = line.find_first_not_of(kBlank);
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    words.push_back(line.substr(0, line.find_first_of(kBlank)));
    line.remove_prefix(words.back().size());
  }
}

// Reads one `name=value`. Returns what is wrong with it; nothing if it is right.
std::string take_setting(std::string_view word, Rights& rights) {
  const std::string_view name = word.substr(0, word.find('='));
  const std::string_view value = word.substr(std::min(name.size() + 1, word.size()));
  if (name == "scope") {
    const std::optional<Scope> scope = scope_named(value);
    if (!scope) return "scope must be view, cut or admin";
    rights.scope = *scope;
  } else if (name == "sheets") {
    if (!is_pattern(value)) return "sheets must be a pattern of small letters, digits, -, * and ?";
    rights.sheets = value;
  } else if (name == "until") {
    const std::optional<std::int64_t> until = day_in(value);
    if (!until) return "until must be a day, YYYY-MM-DD";
    rights.until_unix_s = *until;
  } else {
    return "\"" + std::string(name) + "\" is none of scope, sheets and until";
  }
  return {};
}

// Reads a line. Returns what is wrong with it; nothing if it is right.
std::string take_line(const std::vector<std::string_view>& words, Token& token) {
  if (words.size() < 3) return "a line is ID SHA-256 scope=SCOPE";
  if (!is_id(words[0])) return "an id has 1 to 32 small letters, digits and hyphens";
  token.id = words[0];
  const std::optional<Digest> digest = digest_in(words[1]);
  if (!digest) return "the second word must be the SHA-256 of the token, 64 hexadecimal digits";
  token.digest = *digest;
  std::set<std::string_view> names;
  for (std::size_t i = 2; i < words.size(); ++i) {
    if (!names.insert(words[i].substr(0, words[i].find('='))).second) return "a setting is there twice";
    if (std::string wrong = take_setting(words[i], token.rights); !wrong.empty()) return wrong;
  }
  return names.contains("scope") ? "" : "scope=view, scope=cut or scope=admin is missing";
}

}  // namespace

Result<std::vector<Token>> parse_token_file(std::string_view text) {
  std::vector<Token> tokens;
  std::set<std::string, std::less<>> ids;
  for (int number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::vector<std::string_view> words = words_in(line);
    if (words.empty()) continue;
    Token token;
    std::string wrong = take_line(words, token);
    if (wrong.empty() && !ids.insert(token.id).second) wrong = "the id is there twice";
    if (wrong.empty() && tokens.size() == kMaxTokens) wrong = "there are more than 10,000 tokens";
    if (!wrong.empty()) return invalid_argument("BAD_TOKEN_FILE", "line " + std::to_string(number) + ": " + wrong);
    tokens.push_back(std::move(token));
  }
  return tokens;
}

Result<NewToken> make_token(const std::string& id, Scope scope, const std::string& sheets, const std::string& until) {
  NewToken made;
  made.text = std::string(kPrefix) + id + "_" + new_secret();
  made.line = id + " " + to_hex(digest_of(made.text)) + " scope=" + std::string(name_of(scope));
  if (sheets != "*") made.line += " sheets=" + sheets;
  if (!until.empty()) made.line += " until=" + until;
  Token token;
  std::string wrong = take_line(words_in(made.line), token);
  if (wrong.empty() && !is_id(id)) wrong = "an id has 1 to 32 small letters, digits and hyphens";
  if (wrong.empty() && !is_pattern(sheets)) wrong = "sheets must be a pattern of small letters, digits, -, * and ?";
  if (!wrong.empty()) return invalid_argument("BAD_TOKEN", wrong);
  return made;
}

std::string_view id_in(std::string_view token) {
  if (!token.starts_with(kPrefix)) return {};
  token.remove_prefix(kPrefix.size());
  const std::string_view id = token.substr(0, token.find('_'));
  return is_id(id) && token.size() == id.size() + 1 + kSecretLength ? id : std::string_view();
}

}  // namespace kerf::auth
