// The machine's files, as the store uses them.

#include "server/service/store/files.h"

#include <sys/stat.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace kerf::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(StoreFiles, NamesAndContents) {
  const TemporaryFolder folder;
  store::Files& files = store::real_files();
  const std::string made = folder / "made";
  ASSERT_TRUE(files.make_folder(made).ok());
  ASSERT_TRUE(files.make_folder(made).ok()) << "it is there";
  EXPECT_THAT(*files.list(made), IsEmpty());
  auto file = files.create(made + "/a.new");
  ASSERT_TRUE(file.ok());
  ASSERT_TRUE((*file)->append("text").ok());
  ASSERT_TRUE(files.rename(made + "/a.new", made + "/a").ok());
  ASSERT_TRUE(files.sync_file(made + "/a").ok());
  ASSERT_TRUE(files.sync_folder(made).ok());
  EXPECT_EQ(*files.read(made + "/a", 4), "text");
  EXPECT_EQ(files.read(made + "/a", 3).error().reason, "FILE_TOO_LARGE");
  EXPECT_EQ(*files.size(made + "/a"), 4);
  EXPECT_THAT(*files.list(made), ElementsAre("a"));
  ASSERT_TRUE(files.remove(made + "/a").ok());
  ASSERT_TRUE(files.remove(made + "/a").ok()) << "it is gone";
  EXPECT_EQ(files.size(made + "/a").error().reason, "FILE_NOT_FOUND");
  EXPECT_EQ(files.rename(made + "/a", made + "/b").error().reason, "FILE_NOT_FOUND");
  EXPECT_EQ(files.sync_folder(made + "/none").error().reason, "FILE_NOT_FOUND");
  EXPECT_THAT(*files.list(made + "/none"), IsEmpty());
}

TEST(StoreFiles, AFolderIsMadeWithThoseAroundIt) {
  const TemporaryFolder folder;
  store::Files& files = store::real_files();
  ASSERT_TRUE(files.make_folder(folder / "a/b/c/").ok());
  EXPECT_THAT(*files.list(folder / "a/b"), ElementsAre("c"));
  ASSERT_TRUE(files.create(folder / "file").ok());
  EXPECT_THAT(files.make_folder(folder / "file").error().message, HasSubstr("Not a directory"));
  EXPECT_THAT(files.make_folder(folder / "file/x/y").error().message, HasSubstr("Not a directory"));
}

TEST(StoreFiles, FoldersAreRenamedAndRemovedWhole) {
  const TemporaryFolder folder;
  store::Files& files = store::real_files();
  const std::string from = folder / "from";
  const std::string to = folder / "to";
  for (const std::string& path : {from, from + "/inner", to}) ASSERT_TRUE(files.make_folder(path).ok());
  ASSERT_TRUE(files.create(from + "/inner/a").ok());
  ASSERT_TRUE(files.rename_folder(from, to).ok()) << "an empty folder may have the name";
  EXPECT_THAT(*files.list(to + "/inner"), ElementsAre("a"));
  EXPECT_THAT(*files.list(from), IsEmpty());
  ASSERT_TRUE(files.make_folder(from).ok());
  EXPECT_FALSE(files.rename_folder(from, to).ok()) << "it is not empty";
  EXPECT_THAT(*files.list(to + "/inner"), ElementsAre("a"));
  ASSERT_TRUE(files.remove_folder(to).ok());
  ASSERT_TRUE(files.remove_folder(to).ok()) << "it is gone";
  EXPECT_THAT(*files.list(folder / ""), ElementsAre("from"));
}

TEST(StoreFiles, AReserveTakesBlocks) {
  const TemporaryFolder folder;
  const std::string path = folder / "reserve";
  ASSERT_TRUE(store::real_files().reserve(path, 100'000).ok());
  struct stat about {};
  ASSERT_EQ(::stat(path.c_str(), &about), 0);
  EXPECT_EQ(about.st_size, 100'000);
  EXPECT_GE(about.st_blocks * 512, 100'000);
}

TEST(StoreFiles, AFileThatIsNoFolder) {
  const TemporaryFolder folder;
  const std::string path = folder.write("file", "x");
  EXPECT_FALSE(store::real_files().make_folder(path).ok());
  EXPECT_FALSE(store::real_files().lock(path + "/lock").ok());
}

}  // namespace
}  // namespace kerf::test
