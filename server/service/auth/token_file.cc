#include "server/service/auth/token_file.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>

namespace kerf::auth {
namespace {

constexpr std::string_view kPrefix = "kerf_";
constexpr std::size_t kMaxId = 32;
constexpr std::size_t kMaxTenantName = 16;
constexpr std::size_t kMaxPattern = 128;
constexpr double kMostOfALimit = 1e9;
constexpr std::string_view kTenant = "tenant";
constexpr std::string_view kServersOwn = "sheet";  // begins the ids that the server chooses
constexpr std::size_t kMaxTenants = 1000;
constexpr std::size_t kSecretLength = 43;

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

bool is_id(std::string_view id) {
  return !id.empty() && id.size() <= kMaxId && is_plain(id.front()) &&
         std::all_of(id.begin(), id.end(), [](char c) { return is_plain(c) || c == '-'; });
}

bool is_tenant_name(std::string_view name) {
  return !name.empty() && name.size() <= kMaxTenantName && name.front() >= 'a' && name.front() <= 'z' &&
         std::all_of(name.begin(), name.end(), is_plain);
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

struct Setting {
  explicit Setting(std::string_view word)
      : name(word.substr(0, word.find('='))), value(word.substr(std::min(name.size() + 1, word.size()))) {}
  std::string_view name;
  std::string_view value;
};

// Returns false if one of them is there twice.
bool are_different(const std::vector<std::string_view>& words, std::size_t first) {
  std::set<std::string_view> names;
  for (std::size_t i = first; i < words.size(); ++i) {
    if (!names.insert(Setting(words[i]).name).second) return false;
  }
  return true;
}

// Returns a limit of at least 0; nothing if the text is none.
std::optional<double> limit_in(std::string_view text) {
  double limit = -1.0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), limit, std::chars_format::fixed);
  const bool is_right = fault == std::errc() && end == text.data() + text.size() && limit >= 0.0;
  return is_right && limit <= kMostOfALimit && !std::signbit(limit) ? std::optional(limit) : std::nullopt;
}

// Sets a limit that is a whole number. Returns false if it is none.
template <typename Count>
bool take_count(double value, Count scale, Count& limit) {
  if (value != std::floor(value)) return false;
  limit = static_cast<Count>(value) * scale;
  return true;
}

// Reads one limit of a tenant. Returns what is wrong with it; nothing if it is right.
std::string take_limit(const Setting& setting, TenantLimits& limits) {
  const auto& [name, value] = setting;
  const std::optional<double> limit = limit_in(value);
  bool is_whole = true;
  const double number = limit.value_or(0.0);
  if (name == "sheets") {
    is_whole = take_count<std::int32_t>(number, 1, limits.max_sheets);
  } else if (name == "vertices") {
    is_whole = take_count<std::int64_t>(number, 1, limits.max_vertices);
  } else if (name == "state-mib") {
    is_whole = take_count<std::int64_t>(number, std::int64_t{1} << 20, limits.max_state_bytes);
  } else if (name == "workers") {
    limits.max_workers = number;
  } else if (name == "streams") {
    is_whole = take_count<std::int32_t>(number, 1, limits.max_streams);
  } else if (name == "image-streams") {
    is_whole = take_count<std::int32_t>(number, 1, limits.max_image_streams);
  } else if (name == "cuts-per-s") {
    limits.max_cuts_per_s = number;
  } else {
    return "\"" + std::string(name) +
           "\" is none of sheets, vertices, state-mib, workers, streams, image-streams and cuts-per-s";
  }
  if (limit && is_whole) return {};
  return std::string(name) + " must be a number from 0 to 1000000000" + (limit ? ", a whole one" : "") +
         "; 0: no limit";
}

// Reads the line of a tenant. Returns what is wrong with it; nothing if it is right.
std::string take_tenant(const std::vector<std::string_view>& words, Tenant& tenant) {
  if (words.size() < 2 || !is_tenant_name(words[1])) {
    return "a tenant's name has 1 to 16 small letters and digits, a letter first";
  }
  if (words[1] == kServersOwn)
    return "sheets that the server names begin with sheet-; choose another name for a tenant";
  tenant.name = words[1];
  if (!are_different(words, 2)) return "a limit is there twice";
  for (std::size_t i = 2; i < words.size(); ++i) {
    if (std::string wrong = take_limit(Setting(words[i]), tenant.limits); !wrong.empty()) return wrong;
  }
  return {};
}

// Reads one `name=value` of a token. Returns what is wrong with it; nothing if it is right.
std::string take_setting(const Setting& setting, Rights& rights) {
  const auto& [name, value] = setting;
  if (name == "scope") {
    const std::optional<Scope> scope = scope_named(value);
    if (!scope) return "scope must be view, cut or admin";
    rights.scope = *scope;
  } else if (name == "sheets") {
    if (!is_pattern(value)) return "sheets must be a pattern of small letters, digits, -, * and ?";
    rights.sheets = value;
  } else if (name == kTenant) {
    if (!is_tenant_name(value)) return "tenant must be the name of a tenant";
    rights.tenant = value;
  } else if (name == "until") {
    const std::optional<std::int64_t> until = day_in(value);
    if (!until) return "until must be a day, YYYY-MM-DD";
    rights.until_unix_s = *until;
  } else {
    return "\"" + std::string(name) + "\" is none of scope, tenant, sheets and until";
  }
  return {};
}

// Reads a line. Returns what is wrong with it; nothing if it is right.
std::string take_line(const std::vector<std::string_view>& words, Token& token) {
  if (words.size() < 3) return "a line is ID SHA-256 scope=SCOPE";
  if (words[0] == kTenant) return "a token cannot be called tenant, as that word begins the line of a tenant";
  if (!is_id(words[0])) return "an id has 1 to 32 small letters, digits and hyphens";
  token.id = words[0];
  const std::optional<Digest> digest = digest_in(words[1]);
  if (!digest) return "the second word must be the SHA-256 of the token, 64 hexadecimal digits";
  token.digest = *digest;
  if (!are_different(words, 2)) return "a setting is there twice";
  bool has_scope = false, has_sheets = false;
  for (std::size_t i = 2; i < words.size(); ++i) {
    const Setting setting(words[i]);
    if (std::string wrong = take_setting(setting, token.rights); !wrong.empty()) return wrong;
    has_scope |= setting.name == "scope";
    has_sheets |= setting.name == "sheets";
  }
  if (!has_scope) return "scope=view, scope=cut or scope=admin is missing";
  if (token.rights.tenant.empty()) return {};
  const std::string prefix = token.rights.tenant + "-";
  if (!has_sheets) token.rights.sheets = prefix + "*";
  if (!token.rights.sheets.starts_with(prefix)) return "sheets of this tenant must begin with " + prefix;
  return {};
}

// Returns what is wrong with the tenants of the tokens; nothing if each has a line.
std::string check_tenants(const TokenFile& file) {
  std::set<std::string_view> names;
  for (const Tenant& tenant : file.tenants) names.insert(tenant.name);
  for (const Token& token : file.tokens) {
    const std::string& tenant = token.rights.tenant;
    if (tenant.empty() || names.contains(tenant)) continue;
    return "the tenant of token " + token.id + " has no line; add `tenant " + tenant + "`";
  }
  return {};
}

}  // namespace

Result<TokenFile> parse_token_file(std::string_view text) {
  TokenFile file;
  std::set<std::string, std::less<>> ids;      // of tokens
  std::set<std::string, std::less<>> tenants;  // names
  for (int number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::vector<std::string_view> words = words_in(line);
    if (words.empty()) continue;
    Token token;
    Tenant tenant;
    const bool is_tenant = words[0] == kTenant;
    std::string wrong = is_tenant ? take_tenant(words, tenant) : take_line(words, token);
    if (wrong.empty() && is_tenant && !tenants.insert(tenant.name).second) wrong = "the tenant is there twice";
    if (wrong.empty() && !is_tenant && !ids.insert(token.id).second) wrong = "the id is there twice";
    if (wrong.empty() && !is_tenant && file.tokens.size() == kMaxTokens) wrong = "there are more than 10,000 tokens";
    if (wrong.empty() && is_tenant && file.tenants.size() == kMaxTenants) wrong = "there are more than 1,000 tenants";
    if (!wrong.empty()) return invalid_argument("BAD_TOKEN_FILE", "line " + std::to_string(number) + ": " + wrong);
    if (is_tenant) {
      file.tenants.push_back(std::move(tenant));
    } else {
      file.tokens.push_back(std::move(token));
    }
  }
  if (const std::string wrong = check_tenants(file); !wrong.empty()) return invalid_argument("BAD_TOKEN_FILE", wrong);
  return file;
}

Result<NewToken> make_token(const TokenWish& wish) {
  NewToken made;
  made.text = std::string(kPrefix) + wish.id + "_" + new_secret();
  made.line = wish.id + " " + to_hex(digest_of(made.text)) + " scope=" + std::string(name_of(wish.scope));
  if (!wish.tenant.empty()) made.line += " tenant=" + wish.tenant;
  if (!wish.sheets.empty()) made.line += " sheets=" + wish.sheets;
  if (!wish.until.empty()) made.line += " until=" + wish.until;
  Token token;
  std::string wrong = take_line(words_in(made.line), token);
  if (wrong.empty() && !is_id(wish.id)) wrong = "an id has 1 to 32 small letters, digits and hyphens";
  if (wrong.empty() && !wish.sheets.empty() && !is_pattern(wish.sheets)) {
    wrong = "sheets must be a pattern of small letters, digits, -, * and ?";
  }
  if (wrong.empty() && token.rights.tenant != wish.tenant) wrong = "tenant must be the name of a tenant";
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
