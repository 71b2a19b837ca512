#include "server/service/ws/asset_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "server/base/state_hash.h"
#include "server/service/ws/header_list.h"

namespace kerf::ws {
namespace {

namespace fs = std::filesystem;

Error unreadable(const fs::path& path, std::string_view why) {
  return not_found("VIEWER_UNREADABLE", "cannot read " + path.string() + ": " + std::string(why));
}

std::optional<std::string> read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file.good() && !file.eof()) return std::nullopt;
  return content;
}

std::string etag_of(const std::string& content) {
  StateHash hash;
  hash.add_span(std::span<const char>(content.data(), content.size()));
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string tag = "\"";
  for (int shift = 60; shift >= 0; shift -= 4) tag += kDigits[(hash.value() >> shift) & 15U];
  return tag + '"';
}

// Codings by the extension of their files, the shorter coding first.
constexpr std::array<std::pair<std::string_view, std::string_view>, 2> kCodings{{{".br", "br"}, {".gz", "gzip"}}};

struct File {
  std::string content;
  fs::file_time_type written;
};

using Files = std::map<std::string, File, std::less<>>;  // Files by path.

AssetContent make_content(std::string_view coding, const std::string& bytes) {
  return {coding, std::make_shared<const std::string>(bytes), etag_of(bytes)};
}

bool encodes_another(std::string_view path, const Files& files) {
  return std::ranges::any_of(kCodings, [&](const auto& coding) {
    return path.ends_with(coding.first) && files.contains(path.substr(0, path.size() - coding.first.size()));
  });
}

Asset make_asset(const std::string& path, const Files& files) {
  const File& original = files.find(path)->second;
  Asset asset;
  asset.original = make_content({}, original.content);
  for (const auto& [extension, coding] : kCodings) {
    const auto encoded = files.find(path + std::string(extension));
    if (encoded == files.end() || encoded->second.written < original.written) continue;
    asset.encoded.push_back(make_content(coding, encoded->second.content));
  }
  asset.media_type = media_type_of(path);
  asset.immutable = path.starts_with("/assets/");  // Vite puts the content's hash into these names.
  return asset;
}

}  // namespace

std::string_view media_type_of(std::string_view path) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 17> kTypes{{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".mjs", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".map", "application/json"},
      {".wasm", "application/wasm"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".jpg", "image/jpeg"},
      {".jpeg", "image/jpeg"},
      {".webp", "image/webp"},
      {".ico", "image/x-icon"},
      {".txt", "text/plain; charset=utf-8"},
      {".woff2", "font/woff2"},
      {".glb", "model/gltf-binary"},
      {".webmanifest", "application/manifest+json"},
  }};
  const std::size_t dot = path.find_last_of("./");
  if (dot == std::string_view::npos || path[dot] != '.') return "application/octet-stream";
  std::string extension(path.substr(dot));
  std::ranges::transform(extension, extension.begin(),
                         [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  const auto* const found =
      std::ranges::find(kTypes, std::string_view(extension), &std::pair<std::string_view, std::string_view>::first);
  return found == kTypes.end() ? std::string_view("application/octet-stream") : found->second;
}

const AssetContent& Asset::best_for(std::string_view accept_encoding) const {
  std::vector<std::string_view> codings;
  for (const AssetContent& content : encoded) codings.push_back(content.coding);
  const std::string_view best = best_coding(accept_encoding, codings);
  const auto found = std::ranges::find(encoded, best, &AssetContent::coding);
  return found == encoded.end() ? original : *found;
}

Result<AssetTable> AssetTable::read(const fs::path& directory) {
  std::error_code error;
  if (!fs::is_directory(directory, error)) return unreadable(directory, "no such directory");
  Files files;
  std::size_t bytes = 0;
  fs::recursive_directory_iterator entry(directory, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const fs::directory_entry& file = *entry;
    std::error_code ignored;
    const bool hidden = file.path().filename().string().starts_with('.');
    if (hidden || file.is_symlink(ignored)) {
      if (file.is_directory(ignored)) entry.disable_recursion_pending();
      continue;
    }
    if (!file.is_regular_file(ignored)) continue;
    std::optional<std::string> content = read_file(file.path());
    if (!content) return unreadable(file.path(), "reading failed");
    bytes += content->size();
    if (files.size() == kMaxFiles || bytes > kMaxBytes) {
      return resource_exhausted("VIEWER_TOO_LARGE",
                                directory.string() + " holds more than " + std::to_string(kMaxFiles) + " files or " +
                                    std::to_string(kMaxBytes >> 20) + " MiB; give the folder of a built site");
    }
    std::string path = "/" + file.path().lexically_relative(directory).generic_string();
    files.emplace(std::move(path), File{std::move(*content), file.last_write_time(ignored)});
  }
  if (error) return unreadable(directory, error.message());
  AssetTable table;
  for (const auto& [path, file] : files) {
    if (!encodes_another(path, files)) table.assets_.emplace(path, make_asset(path, files));
  }
  if (table.find("/") == nullptr) return unreadable(directory / "index.html", "no such file");
  return table;
}

void AssetTable::mount(std::string_view prefix, AssetTable site) {
  for (auto& [path, asset] : site.assets_) {
    asset.immutable = false;  // Only the viewer's names change with their content.
    assets_.emplace(std::string(prefix) + path, std::move(asset));
  }
}

const Asset* AssetTable::find(std::string_view path) const {
  const auto found = path.ends_with('/') ? assets_.find(std::string(path) + "index.html") : assets_.find(path);
  return found == assets_.end() ? nullptr : &found->second;
}

}  // namespace kerf::ws
