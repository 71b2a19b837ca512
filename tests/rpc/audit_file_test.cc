// The file of the audit log, and kerfd --audit-log.

#include "server/app/audit_file.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/rpc/kerfd_process.h"

namespace kerf::rpc_test {
namespace {

using ::testing::HasSubstr;

class AuditFileTest : public KerfdTest {
 protected:
  [[nodiscard]] std::string read(const std::string& name) const {
    std::ifstream file(folder_ / name);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  // Returns the audit log once it has a line.
  [[nodiscard]] std::string written() const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kPatienceMs);
    while (!read("audit.log").ends_with('\n') && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    return read("audit.log");
  }

  const std::string path_ = (folder_ / "audit.log").string();
};

TEST_F(AuditFileTest, AppendsToWhatIsThere) {
  write("audit.log", "before\n");
  const auto file = app::AuditFile::open(path_).value();
  EXPECT_TRUE(file->append("one\n"));
  EXPECT_TRUE(file->append("two\n"));
  file->flush();
  EXPECT_EQ(read("audit.log"), "before\none\ntwo\n");
}

TEST_F(AuditFileTest, ANewFileIsForItsOwnerAlone) {
  const auto file = app::AuditFile::open(path_).value();
  EXPECT_EQ(std::filesystem::status(path_).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

TEST_F(AuditFileTest, ContinuesInANewFileAfterTheOldOneWasRenamed) {
  const auto file = app::AuditFile::open(path_).value();
  EXPECT_TRUE(file->append("one\n"));
  file->flush();
  std::filesystem::rename(path_, path_ + ".1");
  EXPECT_TRUE(file->append("two\n"));
  file->flush();
  EXPECT_TRUE(file->reopen().ok());
  EXPECT_TRUE(file->append("three\n"));
  file->flush();
  EXPECT_EQ(read("audit.log.1"), "one\ntwo\n");
  EXPECT_EQ(read("audit.log"), "three\n");
}

TEST_F(AuditFileTest, WritesWhatWaitsWhenItEnds) {
  const auto line = std::string(1000, 'a') + "\n";
  {
    const auto file = app::AuditFile::open(path_).value();
    for (int i = 0; i < 1000; ++i) EXPECT_TRUE(file->append(line));
  }
  EXPECT_EQ(read("audit.log").size(), 1000 * line.size());
}

TEST_F(AuditFileTest, LinesWaitForRoomOnTheDiskUpToALimit) {
  EXPECT_EQ(app::AuditFile::open((folder_ / "none" / "audit.log").string()).error().reason, "BAD_AUDIT_LOG");
  std::filesystem::create_symlink("/dev/full", path_);
  const auto file = app::AuditFile::open(path_, std::chrono::milliseconds(1)).value();
  const std::string line = std::string(1023, 'a') + "\n";
  int taken = 0;
  while (taken < 10'000 && file->append(line)) ++taken;
  EXPECT_EQ(taken, app::AuditFile::kMaxWaitingBytes / line.size());
  std::filesystem::remove(path_);
  EXPECT_TRUE(file->reopen().ok());
  file->flush();
  EXPECT_EQ(read("audit.log").size(), app::AuditFile::kMaxWaitingBytes) << "nothing that was taken is lost";
  EXPECT_TRUE(file->append(line));
}

TEST_F(AuditFileTest, KerfdWritesItAndOpensItAgainOnSighup) {
  EXPECT_THAT(refusal(free_ports({"--audit-log", (folder_ / "none" / "a").string()})), HasSubstr("--audit-log"));
  Kerfd kerfd(free_ports({"--audit-log", path_, "--data", "none"}));
  const int port = ports(kerfd).second;
  const auto pause = [port] {
    return ws_test::request(port, "POST", "/kerf.v1.SheetService/CreateSheet", "Content-Type: application/json\r\n",
                            R"({"scene":{"grid":{"columns":3,"rows":3,"width_m":1,"height_m":1}},"paused":true})")
        .status;
  };
  EXPECT_EQ(pause(), 200);
  const std::string line = written();
  EXPECT_THAT(line, HasSubstr(R"("call":"CreateSheet","outcome":"OK")"));
  EXPECT_THAT(line, HasSubstr(R"("sheet":"sheet-)")) << "the id that the server chose";
  std::filesystem::rename(path_, path_ + ".1");
  kerfd.signal(SIGHUP);
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kPatienceMs);
  while (!std::filesystem::exists(path_)) ASSERT_LT(std::chrono::steady_clock::now(), end);
  EXPECT_EQ(pause(), 200);
  EXPECT_THAT(written(), HasSubstr("CreateSheet"));
  EXPECT_EQ(read("audit.log.1"), line);
}

}  // namespace
}  // namespace kerf::rpc_test
