// Prints every message of an MCAP file as a line of JSON, as Foxglove decodes it: node decode.mjs FILE
import { readFileSync } from "node:fs";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader, TempBuffer } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";

const plain = (key, value) => {
  if (typeof value === "bigint") return Number(value);
  if (ArrayBuffer.isView(value)) return Array.from(value, Number);
  return value;
};

const readable = new TempBuffer(readFileSync(process.argv[2]));
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
const readers = new Map();
for (const [id, schema] of reader.schemasById) {
  const definitions = parse(new TextDecoder().decode(schema.data), { ros2: true });
  readers.set(id, new MessageReader(definitions, { timeType: "sec,nanosec" }));
}
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  const fields = readers.get(channel.schemaId).readMessage(message.data);
  const time = message.logTime.toString();
  process.stdout.write(JSON.stringify({ topic: channel.topic, time, fields }, plain) + "\n");
}
