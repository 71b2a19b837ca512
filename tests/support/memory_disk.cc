#include "tests/support/memory_disk.h"

#include <utility>

namespace kerf::test {

namespace {

Error disk_full(const std::string& path) {
  return resource_exhausted("DISK_FULL", "no room left for \"" + path + "\"");
}

}  // namespace

class MemoryDisk::MemoryFile : public AppendFile {
 public:
  MemoryFile(std::shared_ptr<Content> content, std::string path)
      : content_(std::move(content)), path_(std::move(path)) {}

  Status append(std::string_view bytes) override {
    const std::lock_guard lock(content_->mutex);
    if (content_->used_bytes + bytes.size() > content_->capacity_bytes) return disk_full(path_);
    content_->used_bytes += bytes.size();
    content_->files[path_].append(bytes);
    return Nothing{};
  }
  Status sync() override { return Nothing{}; }

 private:
  std::shared_ptr<Content> content_;
  std::string path_;
};

MemoryDisk::MemoryDisk(std::size_t capacity_bytes) : content_(std::make_shared<Content>()) {
  content_->capacity_bytes = capacity_bytes;
}

void MemoryDisk::set_capacity(std::size_t bytes) {
  const std::lock_guard lock(content_->mutex);
  content_->capacity_bytes = bytes;
}

Result<std::string> MemoryDisk::read_file(const std::string& path, std::size_t max_bytes) {
  const std::lock_guard lock(content_->mutex);
  const auto found = content_->files.find(path);
  if (found == content_->files.end()) {
    return not_found("FILE_NOT_FOUND", "there is no file \"" + path + "\"");
  }
  if (found->second.size() > max_bytes) {
    return resource_exhausted("FILE_TOO_LARGE",
                              "\"" + path + "\" has more than " + std::to_string(max_bytes) + " bytes, the limit");
  }
  return found->second;
}

Status MemoryDisk::write_file(const std::string& path, std::string_view content) {
  const std::lock_guard lock(content_->mutex);
  // Needs room for old and new content, because the old one is dropped only once the new one is complete.
  if (content_->used_bytes + content.size() > content_->capacity_bytes) return disk_full(path);
  std::string& file = content_->files[path];
  content_->used_bytes += content.size();
  content_->used_bytes -= file.size();
  file.assign(content);
  return Nothing{};
}

Result<std::unique_ptr<AppendFile>> MemoryDisk::create_file(const std::string& path) {
  const std::lock_guard lock(content_->mutex);
  std::string& file = content_->files[path];
  content_->used_bytes -= file.size();
  file.clear();
  return std::unique_ptr<AppendFile>(std::make_unique<MemoryFile>(content_, path));
}

}  // namespace kerf::test
