// SPDX-License-Identifier: BSD-3-Clause
// Runs the tests of one program on every rank, in the same order. Ranks other than 0 report only
// failures.
#include "farm/environment.hpp"

#include <iostream>

#include <gtest/gtest.h>

namespace {

class FailurePrinter : public ::testing::EmptyTestEventListener {
  public:
    explicit FailurePrinter(int rank) : rank_(rank) {}

    void OnTestPartResult(const ::testing::TestPartResult& result) override {
        if (result.failed())
            std::cerr << "rank " << rank_ << ": " << result.file_name() << ':'
                      << result.line_number() << ": " << result.message() << std::endl;
    }

  private:
    int rank_;
};

} // namespace

int main(int argc, char** argv) {
    ::testing::InitGoogleTest(&argc, argv);
    const culm::farm::Environment environment(argc, argv);
    if (const int rank = environment.world().rank(); rank != 0) {
        ::testing::TestEventListeners& listeners = ::testing::UnitTest::GetInstance()->listeners();
        delete listeners.Release(listeners.default_result_printer());
        listeners.Append(new FailurePrinter(rank));
    }
    return RUN_ALL_TESTS();
}
