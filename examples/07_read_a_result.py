"""Write a result as Parquet, read it back: scenario, arrays and summary are the same."""

import echelon

echelon.simulate("triangle-circle", {"duration": 5}).to_parquet("triangle.parquet")
result = echelon.read("triangle.parquet")
print(result, result.summary()["tracking_error_m"]["rms"])
