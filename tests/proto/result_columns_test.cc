#include "proto/result_columns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/bulk_message.h"

namespace curvature::wire {
namespace {

const ResultColumn* Find(std::string_view name) {
  for (const ResultColumn& column : ResultColumns()) {
    if (column.name == name) return &column;
  }
  return nullptr;
}

TEST(ResultColumnsTest, EveryArrayOfAResultChunkIsAColumn) {
  const google::protobuf::Descriptor& chunk = *v1::ResultChunk::descriptor();
  for (int i = 0; i < chunk.field_count(); ++i) {
    const bool is_array = chunk.field(i)->type() == google::protobuf::FieldDescriptor::TYPE_BYTES;
    EXPECT_EQ(Find(chunk.field(i)->name()) != nullptr, is_array) << chunk.field(i)->name();
  }
}

TEST(ResultColumnsTest, TellTypeWidthAndQuantity) {
  const ResultColumn* status = Find("status");
  ASSERT_NE(status, nullptr);
  EXPECT_EQ(status->quantity, v1::QUANTITY_UNSPECIFIED);
  EXPECT_EQ(status->type, v1::COLUMN_TYPE_UINT8);
  EXPECT_EQ(status->bytes_per_point, 1u);
  const ResultColumn* d2 = Find("d2");
  ASSERT_NE(d2, nullptr);
  EXPECT_EQ(d2->field, v1::ResultChunk::kD2FieldNumber);
  EXPECT_EQ(d2->quantity, v1::QUANTITY_PRINCIPAL_DIRECTIONS);
  EXPECT_EQ(d2->type, v1::COLUMN_TYPE_FLOAT32);
  EXPECT_EQ(d2->width, 3u);
  EXPECT_EQ(d2->bytes_per_point, 12u);
}

TEST(ResultColumnsTest, AreReadWithoutACopy) {
  for (const ResultColumn& column : ResultColumns()) EXPECT_LT(column.field, kFieldEnd) << column.name;
}

TEST(ResultColumnsTest, EveryQuantityAsksForAColumn) {
  for (const v1::Quantity quantity : Quantities()) {
    EXPECT_THAT(ResultColumns(), testing::Contains(testing::Field(&ResultColumn::quantity, quantity)))
        << QuantityName(quantity);
  }
}

TEST(QuantityNameTest, IsThatOfTheContractInLowerCase) {
  EXPECT_EQ(QuantityName(v1::QUANTITY_MEAN_CURVATURE), "mean_curvature");
  EXPECT_EQ(QuantityOf("principal_directions"), v1::QUANTITY_PRINCIPAL_DIRECTIONS);
  EXPECT_EQ(QuantityOf("unspecified"), std::nullopt);
  EXPECT_EQ(QuantityOf("k1"), std::nullopt);
  EXPECT_EQ(QuantityName(static_cast<v1::Quantity>(99)), "");
}

}  // namespace
}  // namespace curvature::wire
