#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/base/random.h"
#include "server/service/store/files.h"

namespace kerf::test {

// A disk in memory that can lose power. What was written and not synced is then kept, lost or torn at sectors of 512
// bytes, in any order. New, other and removed names of files are lost if their folder was not synced. Thread-safe.
class LossyDisk : public store::Files {
 public:
  static constexpr std::size_t kSectorBytes = 512;

  // A write, or a new length if there are no bytes.
  struct Write {
    std::size_t at = 0;
    std::string bytes;
    bool is_length = false;
  };
  struct Node {
    std::string content;         // as a process sees it
    std::string durable;         // on the disk for sure
    std::vector<Write> pending;  // may be there as well
  };

  // Functions of Files.
  Status make_folder(const std::string& path) override;
  Result<std::unique_ptr<store::FileLock>> lock(const std::string& path) override;
  Result<std::int64_t> size(const std::string& path) override;
  bool is_writable(const std::string& /*path*/) override { return true; }
  Result<std::vector<std::string>> list(const std::string& folder) override;
  Result<std::string> read(const std::string& path, std::size_t max_bytes) override;
  Result<std::unique_ptr<AppendFile>> create(const std::string& path) override;
  Status rename(const std::string& from, const std::string& to) override;
  Status rename_folder(const std::string& from, const std::string& to) override;
  Status remove_folder(const std::string& path) override;
  Status remove(const std::string& path) override;
  Status reserve(const std::string& path, std::int64_t bytes) override;
  Status sync_file(const std::string& path) override;
  Status sync_folder(const std::string& path) override;

  // Functions for a virtual file system of SQLite.
  enum class Outcome { kDone, kFull, kFailed };
  // Returns the file, or nullptr if there is none and `create` is false. An empty path: a file without a name.
  std::shared_ptr<Node> open(const std::string& path, bool create, bool* was_made);
  std::size_t read_at(Node& node, std::size_t at, char* bytes, std::size_t count);
  Outcome write_at(Node& node, std::size_t at, std::string_view bytes);
  Outcome set_length(Node& node, std::size_t length);
  Outcome sync(Node& node, bool is_log);
  std::size_t length(const Node& node) const;

  // Lets power fail before the operation with this number from now on: that and all later ones fail.
  void lose_power_after(std::int64_t operations);
  // Makes the disk's content one of those that a loss of power may leave. Power and locks are then as at a start.
  void restart(SeededRandom& random);
  [[nodiscard]] std::int64_t num_operations() const;

  // Faults, each until it is taken back.
  void set_capacity(std::size_t bytes);
  void fail_syncs(bool fails);  // Then nothing that waited is ever on the disk.
  void hang(bool hangs);        // Operations wait.
  void ignore_folder_syncs();   // As a program that forgets them.
  void ignore_log_syncs();      // As `synchronous = NORMAL` of SQLite.

  // Contents by path, all of them synced.
  [[nodiscard]] std::map<std::string, std::string> contents() const;
  void set_contents(const std::map<std::string, std::string>& contents);

 private:
  struct NameChange {
    enum class Kind { kLink, kUnlink, kRename } kind = Kind::kLink;
    std::string name;
    std::string to;  // of kRename
    std::shared_ptr<Node> node;
  };
  using Names = std::map<std::string, std::shared_ptr<Node>>;
  class Lock;
  class File;

  // Counts an operation. Returns false if power is off.
  bool begin(std::unique_lock<std::mutex>& lock);
  void change_name(NameChange change);
  static void apply(const NameChange& change, Names& names);
  [[nodiscard]] bool has_room_for(std::size_t more) const;

  mutable std::mutex mutex_;
  std::condition_variable released_;
  Names names_;
  Names durable_names_;
  std::vector<NameChange> pending_names_;
  std::set<std::string> locked_;
  std::int64_t num_operations_ = 0;
  std::int64_t power_ends_ = std::numeric_limits<std::int64_t>::max();
  std::size_t capacity_ = std::numeric_limits<std::size_t>::max();
  bool syncs_fail_ = false;
  bool hangs_ = false;
  bool ignores_folder_syncs_ = false;
  bool ignores_log_syncs_ = false;
};

}  // namespace kerf::test
