// SPDX-License-Identifier: BSD-3-Clause
// Values are encoded and decoded bit for bit, and damaged messages are detected.
#include "core/wire.hpp"

#include "core/item_map.hpp"

#include <bit>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace culm::core {
namespace {

enum class Status { Converged, AtBound, Stopped };

struct Parameter {
    std::string name;
    double value = 0.0;
    std::optional<double> standard_error;
    friend bool operator==(const Parameter&, const Parameter&) = default;
};

struct Fit {
    Status status = Status::Converged;
    std::vector<Parameter> parameters;
    std::vector<double> residuals;
    std::vector<std::vector<int>> groups;
    std::vector<bool> kept;
    std::array<double, 3> tip{};
    std::map<std::string, double> by_effect;
    std::pair<std::string, bool> reason;
    std::optional<Parameter> best;
    Parameter first;
    std::shared_ptr<const Parameter> shared;
    bool has_ended_early = false;
    friend bool operator==(const Fit&, const Fit&) = default;
};

Fit full_fit() {
    Fit fit;
    fit.status = Status::Stopped;
    fit.parameters = {{"bond_damping", 0.1, 1e-300}, {"", -0.0, std::nullopt}};
    fit.residuals = {1.0 / 3.0, std::numeric_limits<double>::infinity(),
                     std::numeric_limits<double>::denorm_min()};
    fit.groups = {{1, 2}, {}, {-3}};
    fit.kept = {true, false, true};
    fit.tip = {1e-3, -2.0, 7.0};
    fit.by_effect = {{"gravity", -4.5}, {"taper", 1e9}};
    fit.reason = {std::string("zero \0 inside", 13), true};
    fit.best = Parameter{"Y", 2e9, 1e6};
    fit.first = {"beta", 0.05, 0.01};
    fit.has_ended_early = true;
    return fit;
}

TEST(Wire, PreservesAStruct) {
    EXPECT_EQ(decoded<Fit>(encoded(full_fit())), full_fit());
    EXPECT_EQ(decoded<Fit>(encoded(Fit())), Fit());
}

TEST(Wire, CopiesWhatASharedPointerPointsTo) {
    Fit fit;
    fit.shared = std::make_shared<const Parameter>(Parameter{"Y", 2e9, std::nullopt});
    EXPECT_EQ(*decoded<Fit>(encoded(fit)).shared, *fit.shared);
}

struct Rung {
    double height = 0.0;
    std::string name;
    friend bool operator==(const Rung&, const Rung&) = default;
};

struct RungWithAngle {
    double height = 0.0;
    std::string name;
    std::optional<double> angle; ///< the new member; nothing else names it
    friend bool operator==(const RungWithAngle&, const RungWithAngle&) = default;
};

TEST(Wire, TakesANewMemberOfAStructFromItsDeclaration) {
    EXPECT_EQ(decoded<Rung>(encoded(Rung{0.1, "S01"})), (Rung{0.1, "S01"}));
    const RungWithAngle rung{0.1, "S01", 0.5};
    EXPECT_EQ(decoded<RungWithAngle>(encoded(rung)), rung);
    Bytes bytes = encoded(Rung{0.1, "S01"});
    const Bytes angle = encoded(rung.angle);
    bytes.insert(bytes.end(), angle.begin(), angle.end());
    EXPECT_EQ(encoded(rung), bytes);
}

struct Partial {
    double value = 0.0;
    double local = 0.0;
};

template <class Wire>
void fields(Wire& wire, Partial& partial) {
    wire(partial.value);
}

struct Derived : Rung {
    int place = 0;
};

template <class Wire>
void fields(Wire& wire, Derived& derived) {
    wire(derived.place, derived.height);
}

TEST(Wire, SendsOnlyWhatAListNames) {
    const auto partial = decoded<std::vector<Partial>>(encoded(std::vector<Partial>{{1.0, 2.0}}));
    EXPECT_EQ(partial.front().value, 1.0);
    EXPECT_EQ(partial.front().local, 0.0);
    const auto derived = decoded<Derived>(encoded(Derived{{0.1, "S01"}, 3}));
    EXPECT_EQ(derived.height, 0.1);
    EXPECT_EQ(derived.name, "");
    EXPECT_EQ(derived.place, 3);
}

TEST(Wire, KeepsEveryBitOfADouble) {
    for (const std::uint64_t bits : {0x8000000000000000ULL, 0x7FF8000000000001ULL,
                                     0xFFF4000000000000ULL, 0x3FB999999999999AULL}) {
        const auto value = std::bit_cast<double>(bits);
        EXPECT_EQ(std::bit_cast<std::uint64_t>(decoded<double>(encoded(value))), bits);
        EXPECT_EQ(std::bit_cast<std::uint64_t>(
                      decoded<std::vector<double>>(encoded(std::vector<double>{value}))[0]),
                  bits);
    }
}

TEST(Wire, RefusesEveryTruncatedMessage) {
    const Bytes whole = encoded(full_fit());
    for (std::size_t length = 0; length < whole.size(); ++length)
        EXPECT_THROW((void)decoded<Fit>(
                         Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length))),
                     WireError)
            << length << " bytes";
}

TEST(Wire, RefusesAMessageWithExtraBytes) {
    Bytes bytes = encoded(full_fit());
    bytes.push_back(std::byte{0});
    EXPECT_THROW((void)decoded<Fit>(bytes), WireError);
}

TEST(Wire, RefusesALengthBeyondTheMessageBeforeItAllocates) {
    const Bytes huge = encoded(~std::size_t{0} / 16);
    EXPECT_THROW((void)decoded<std::string>(huge), WireError);
    EXPECT_THROW((void)decoded<std::vector<double>>(huge), WireError);
    EXPECT_THROW((void)decoded<std::vector<std::string>>(huge), WireError);
}

struct Form {
    Eigen::VectorXd gradient;
    Eigen::MatrixXd hessian;
    double offset = 0.0;
};

TEST(Wire, PreservesTheShapeAndTheEntriesOfAMatrix) {
    const Form form{Eigen::VectorXd{{1.0, -0.0, 3.0}},
                    Eigen::MatrixXd{{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}}, 0.5};
    const auto same = decoded<Form>(encoded(form));
    EXPECT_EQ(same.gradient, form.gradient);
    EXPECT_TRUE(std::signbit(same.gradient(1)));
    EXPECT_EQ(same.hessian, form.hessian);
    EXPECT_EQ(same.offset, 0.5);
    const auto empty = decoded<Eigen::MatrixXd>(encoded(Eigen::MatrixXd(0, 4)));
    EXPECT_EQ(empty.rows(), 0);
    EXPECT_EQ(empty.cols(), 4);
}

TEST(Wire, RefusesADamagedSizeOfAMatrixBeforeItAllocates) {
    constexpr Eigen::Index huge = Eigen::Index{1} << 62;
    const auto is_refused = [](Eigen::Index rows, Eigen::Index columns) {
        const Bytes message = encoded(std::pair(std::pair(rows, columns), std::array{1.0, 2.0}));
        EXPECT_THROW((void)decoded<Eigen::MatrixXd>(message), WireError) << rows << ", " << columns;
    };
    is_refused(huge, 1);
    is_refused(1, huge);
    is_refused(huge, 4); // the product overflows to 0
    is_refused(-1, 2);
    is_refused(2, -1);
    is_refused(2, 2);
    const Bytes matrix = encoded(Eigen::MatrixXd::Ones(1, 2).eval());
    EXPECT_THROW((void)decoded<Eigen::VectorXd>(matrix), WireError);
}

TEST(ItemMap, GivesEveryOutcomeInTheOrderOfTheItems) {
    const std::vector<ItemOutcome<Fit>> found =
        ItemMap().outcomes({1.0, 3.0, 2.0}, [](std::size_t item, const Heartbeat&) {
            if (item == 1)
                throw std::runtime_error("no fit");
            Fit fit = full_fit();
            fit.tip[0] = static_cast<double>(item);
            return fit;
        });
    ASSERT_EQ(found.size(), 3U);
    EXPECT_EQ(found[0].value->tip[0], 0.0);
    EXPECT_EQ(found[2].value->tip[0], 2.0);
    EXPECT_FALSE(found[1].value.has_value());
    EXPECT_EQ(found[1].failure, "no fit");
}

TEST(ItemMap, ReportsTheReasonWhenAnItemThrows) {
    const auto work = [](std::size_t item, const Heartbeat&) {
        if (item == 2)
            throw std::logic_error("odd");
        return item;
    };
    EXPECT_EQ(ItemMap().values({1.0, 1.0}, work), (std::vector<std::size_t>{0U, 1U}));
    try {
        (void)ItemMap().values({1.0, 1.0, 1.0}, work);
        FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "item 2: odd");
    }
}

TEST(ItemMap, EndsOnAFullDisk) {
    EXPECT_THROW((void)ItemMap().outcomes({1.0},
                                          [](std::size_t, const Heartbeat&) -> int {
                                              throw StorageError("no space left");
                                          }),
                 StorageError);
}

} // namespace
} // namespace culm::core
