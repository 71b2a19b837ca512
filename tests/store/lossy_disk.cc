#include "tests/store/lossy_disk.h"

#include <algorithm>

namespace kerf::test {
namespace {

Error no_power(const std::string& path) {
  return unavailable("FILE_IO", "\"" + path + "\": the power is off, or the disk fails");
}
Error no_file(const std::string& path) {
  return not_found("FILE_NOT_FOUND", "\"" + path + "\" is not there");
}
Error full_disk(const std::string& path) {
  return resource_exhausted("DISK_FULL", "\"" + path + "\": the disk is full");
}

Status status_of(LossyDisk::Outcome outcome, const std::string& path) {
  switch (outcome) {
    case LossyDisk::Outcome::kDone:
      return Nothing{};
    case LossyDisk::Outcome::kFull:
      return full_disk(path);
    case LossyDisk::Outcome::kFailed:
      return no_power(path);
  }
  return no_power(path);
}

std::string folder_of(const std::string& path) {
  return path.substr(0, path.rfind('/'));
}

void put(std::string& content, std::size_t at, std::string_view bytes) {
  if (content.size() < at + bytes.size()) content.resize(at + bytes.size(), '\0');
  std::copy(bytes.begin(), bytes.end(), content.begin() + static_cast<std::ptrdiff_t>(at));
}

// Draws what is left of a file: each sector of each write by itself.
std::string left_of(const LossyDisk::Node& node, double kept, SeededRandom& random) {
  std::string left = node.durable;
  for (const LossyDisk::Write& write : node.pending) {
    if (write.is_length) {
      if (random.uniform() < kept) left.resize(write.at, '\0');
      continue;
    }
    for (std::size_t done = 0; done < write.bytes.size();) {
      const std::size_t at = write.at + done;
      const std::size_t count =
          std::min(LossyDisk::kSectorBytes - at % LossyDisk::kSectorBytes, write.bytes.size() - done);
      if (random.uniform() < kept) put(left, at, std::string_view(write.bytes).substr(done, count));
      done += count;
    }
  }
  return left;
}

// Draws the share of changes that a loss of power keeps: none, all, or any.
double share(SeededRandom& random) {
  const double shares[] = {0.0, 1.0, 0.5, random.uniform()};
  return shares[random.below(4)];
}

}  // namespace

class LossyDisk::Lock : public store::FileLock {
 public:
  Lock(LossyDisk& disk, std::string path) : disk_(disk), path_(std::move(path)) {}
  ~Lock() override {
    const std::lock_guard guard(disk_.mutex_);
    disk_.locked_.erase(path_);
  }

 private:
  LossyDisk& disk_;
  std::string path_;
};

class LossyDisk::File : public AppendFile {
 public:
  File(LossyDisk& disk, std::string path, std::shared_ptr<Node> node)
      : disk_(disk), path_(std::move(path)), node_(std::move(node)) {}
  Status append(std::string_view bytes) override {
    return status_of(disk_.write_at(*node_, disk_.length(*node_), bytes), path_);
  }
  Status sync() override { return status_of(disk_.sync(*node_, false), path_); }

 private:
  LossyDisk& disk_;
  std::string path_;
  std::shared_ptr<Node> node_;
};

bool LossyDisk::begin(std::unique_lock<std::mutex>& lock) {
  released_.wait(lock, [this] { return !hangs_; });
  return ++num_operations_ < power_ends_;
}

void LossyDisk::apply(const NameChange& change, Names& names) {
  switch (change.kind) {
    case NameChange::Kind::kLink:
      names[change.name] = change.node;
      return;
    case NameChange::Kind::kUnlink:
      names.erase(change.name);
      return;
    case NameChange::Kind::kRename:
      break;
  }
  const auto found = names.find(change.name);
  if (found == names.end()) return;
  const std::shared_ptr<Node> node = found->second;
  names.erase(found);
  names[change.to] = node;
}

void LossyDisk::change_name(NameChange change) {
  apply(change, names_);
  pending_names_.push_back(std::move(change));
}

Status LossyDisk::make_folder(const std::string&) {
  return Nothing{};  // folders are always there
}

Result<std::unique_ptr<store::FileLock>> LossyDisk::lock(const std::string& path) {
  if (open(path, true, nullptr) == nullptr) return no_power(path);
  const std::lock_guard guard(mutex_);
  if (!locked_.insert(path).second) return failed_precondition("STORE_IN_USE", "\"" + path + "\" is locked");
  return std::unique_ptr<store::FileLock>(std::make_unique<Lock>(*this, path));
}

Result<std::int64_t> LossyDisk::size(const std::string& path) {
  const std::lock_guard guard(mutex_);
  const auto found = names_.find(path);
  if (found == names_.end()) return no_file(path);
  return static_cast<std::int64_t>(found->second->content.size());
}

Result<std::vector<std::string>> LossyDisk::list(const std::string& folder) {
  const std::lock_guard guard(mutex_);
  std::vector<std::string> found;
  for (const auto& [path, node] : names_) {
    if (folder_of(path) == folder) found.push_back(path.substr(folder.size() + 1));
  }
  return found;
}

Result<std::string> LossyDisk::read(const std::string& path, std::size_t max_bytes) {
  const std::lock_guard guard(mutex_);
  const auto found = names_.find(path);
  if (found == names_.end()) return no_file(path);
  if (found->second->content.size() > max_bytes) return resource_exhausted("FILE_TOO_LARGE", path);
  return found->second->content;
}

Result<std::unique_ptr<AppendFile>> LossyDisk::create(const std::string& path) {
  bool was_made = false;
  const std::shared_ptr<Node> node = open(path, true, &was_made);
  if (node == nullptr) return no_power(path);
  if (!was_made) KERF_TRY(status_of(set_length(*node, 0), path));
  return std::unique_ptr<AppendFile>(std::make_unique<File>(*this, path, node));
}

Status LossyDisk::rename(const std::string& from, const std::string& to) {
  std::unique_lock lock(mutex_);
  if (!begin(lock)) return no_power(from);
  if (names_.count(from) == 0) return no_file(from);
  change_name({NameChange::Kind::kRename, from, to, nullptr});
  return Nothing{};
}

// All of it has the new name for sure, or nothing has: the folder around it is synced.
Status LossyDisk::rename_folder(const std::string& from, const std::string& to) {
  std::unique_lock lock(mutex_);
  if (!begin(lock)) return no_power(from);
  const std::string below = from + "/";
  const auto renamed = [&](const std::string& path) {
    return path.compare(0, below.size(), below) == 0 ? to + "/" + path.substr(below.size()) : path;
  };
  for (Names* const names : {&names_, &durable_names_}) {
    Names moved;
    for (const auto& [path, node] : *names) moved[renamed(path)] = node;
    *names = std::move(moved);
  }
  for (NameChange& change : pending_names_) {
    change.name = renamed(change.name);
    change.to = renamed(change.to);
  }
  return Nothing{};
}

Status LossyDisk::remove_folder(const std::string& path) {
  std::unique_lock lock(mutex_);
  if (!begin(lock)) return no_power(path);
  std::vector<std::string> found;
  for (const auto& [name, node] : names_) {
    if (name.compare(0, path.size() + 1, path + "/") == 0) found.push_back(name);
  }
  for (const std::string& name : found) change_name({NameChange::Kind::kUnlink, name, {}, nullptr});
  return Nothing{};
}

Status LossyDisk::remove(const std::string& path) {
  std::unique_lock lock(mutex_);
  if (!begin(lock)) return no_power(path);
  if (names_.count(path) > 0) change_name({NameChange::Kind::kUnlink, path, {}, nullptr});
  return Nothing{};
}

Status LossyDisk::reserve(const std::string& path, std::int64_t bytes) {
  const std::shared_ptr<Node> node = open(path, true, nullptr);
  if (node == nullptr) return no_power(path);
  const Status written = status_of(write_at(*node, 0, std::string(static_cast<std::size_t>(bytes), '\0')), path);
  if (!written.ok()) {
    KERF_TRY(remove(path));
    return written;
  }
  return status_of(sync(*node, false), path);
}

Status LossyDisk::sync_file(const std::string& path) {
  const std::shared_ptr<Node> node = open(path, false, nullptr);
  return node == nullptr ? Status(no_file(path)) : status_of(sync(*node, false), path);
}

Status LossyDisk::sync_folder(const std::string& path) {
  std::unique_lock lock(mutex_);
  if (!begin(lock) || syncs_fail_) return no_power(path);
  if (ignores_folder_syncs_) return Nothing{};
  std::vector<NameChange> rest;
  for (const NameChange& change : pending_names_) {
    if (folder_of(change.name) == path) {
      apply(change, durable_names_);
    } else {
      rest.push_back(change);
    }
  }
  pending_names_ = std::move(rest);
  return Nothing{};
}

std::shared_ptr<LossyDisk::Node> LossyDisk::open(const std::string& path, bool create, bool* was_made) {
  std::unique_lock lock(mutex_);
  const auto found = names_.find(path);
  if (was_made != nullptr) *was_made = found == names_.end();
  if (found != names_.end()) return found->second;
  if (path.empty()) return std::make_shared<Node>();
  if (!create || !begin(lock)) return nullptr;
  auto node = std::make_shared<Node>();
  change_name({NameChange::Kind::kLink, path, {}, node});
  return node;
}

std::size_t LossyDisk::read_at(Node& node, std::size_t at, char* bytes, std::size_t count) {
  const std::lock_guard guard(mutex_);
  if (at >= node.content.size()) return 0;
  return node.content.copy(bytes, count, at);
}

bool LossyDisk::has_room_for(std::size_t more) const {
  if (capacity_ == std::numeric_limits<std::size_t>::max()) return true;
  std::size_t used = 0;
  for (const auto& [path, node] : names_) used += node->content.size();
  return more <= capacity_ && used <= capacity_ - more;
}

LossyDisk::Outcome LossyDisk::write_at(Node& node, std::size_t at, std::string_view bytes) {
  std::unique_lock lock(mutex_);
  if (!begin(lock)) return Outcome::kFailed;
  const std::size_t end = at + bytes.size();
  if (end > node.content.size() && !has_room_for(end - node.content.size())) return Outcome::kFull;
  put(node.content, at, bytes);
  node.pending.push_back({at, std::string(bytes), false});
  return Outcome::kDone;
}

LossyDisk::Outcome LossyDisk::set_length(Node& node, std::size_t length) {
  std::unique_lock lock(mutex_);
  if (!begin(lock)) return Outcome::kFailed;
  node.content.resize(length, '\0');
  node.pending.push_back({length, {}, true});
  return Outcome::kDone;
}

LossyDisk::Outcome LossyDisk::sync(Node& node, bool is_log) {
  std::unique_lock lock(mutex_);
  if (!begin(lock)) return Outcome::kFailed;
  if (is_log && ignores_log_syncs_) return Outcome::kDone;
  for (const Write& write : node.pending) {
    if (syncs_fail_) break;
    if (write.is_length) {
      node.durable.resize(write.at, '\0');
    } else {
      put(node.durable, write.at, write.bytes);
    }
  }
  node.pending.clear();
  return syncs_fail_ ? Outcome::kFailed : Outcome::kDone;
}

std::size_t LossyDisk::length(const Node& node) const {
  const std::lock_guard guard(mutex_);
  return node.content.size();
}

void LossyDisk::lose_power_after(std::int64_t operations) {
  const std::lock_guard guard(mutex_);
  power_ends_ = num_operations_ + operations;
}

void LossyDisk::restart(SeededRandom& random) {
  const std::lock_guard guard(mutex_);
  const double kept_names = share(random);
  for (const NameChange& change : pending_names_) {
    if (random.uniform() < kept_names) apply(change, durable_names_);
  }
  pending_names_.clear();
  names_ = durable_names_;
  const double kept_writes = share(random);
  for (const auto& [path, node] : names_) {
    node->durable = left_of(*node, kept_writes, random);
    node->content = node->durable;
    node->pending.clear();
  }
  locked_.clear();
  num_operations_ = 0;
  power_ends_ = std::numeric_limits<std::int64_t>::max();
}

std::int64_t LossyDisk::num_operations() const {
  const std::lock_guard guard(mutex_);
  return num_operations_;
}

void LossyDisk::set_capacity(std::size_t bytes) {
  const std::lock_guard guard(mutex_);
  capacity_ = bytes;
}

void LossyDisk::fail_syncs(bool fails) {
  const std::lock_guard guard(mutex_);
  syncs_fail_ = fails;
}

void LossyDisk::hang(bool hangs) {
  const std::lock_guard guard(mutex_);
  hangs_ = hangs;
  released_.notify_all();
}

void LossyDisk::ignore_folder_syncs() {
  ignores_folder_syncs_ = true;
}

void LossyDisk::ignore_log_syncs() {
  ignores_log_syncs_ = true;
}

std::map<std::string, std::string> LossyDisk::contents() const {
  const std::lock_guard guard(mutex_);
  std::map<std::string, std::string> contents;
  for (const auto& [path, node] : names_) contents[path] = node->content;
  return contents;
}

void LossyDisk::set_contents(const std::map<std::string, std::string>& contents) {
  const std::lock_guard guard(mutex_);
  names_.clear();
  for (const auto& [path, content] : contents) {
    names_[path] = std::make_shared<Node>(Node{content, content, {}});
  }
  durable_names_ = names_;
  pending_names_.clear();
}

}  // namespace kerf::test
