#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace kerf::api {

// Defines a stream that Api::stop() notifies.
class OpenStream {
 public:
  virtual ~OpenStream() = default;
  // Ends the stream with kUnavailable if it has not been started. StreamHub::stop() ends streams that watch a sheet.
  virtual void server_stops() = 0;
  // Looks whether its caller is still granted what it does, and ends the stream if not.
  virtual void check_caller() = 0;
};

// Lists the open streams. Thread-safe.
class OpenStreams {
 public:
  void add(const std::shared_ptr<OpenStream>& stream);
  void remove(const OpenStream& stream);
  // Calls server_stops() of each.
  void notify_stop();
  // Calls check_caller() of each.
  void check_callers();

 private:
  std::vector<std::shared_ptr<OpenStream>> open();

  std::mutex mutex_;
  std::map<const OpenStream*, std::weak_ptr<OpenStream>> streams_;  // guarded by mutex_
};

}  // namespace kerf::api
