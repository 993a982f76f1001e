// Files that the browser saves, and the clipboard.

/** @param {Blob} blob @param {string} name */
export function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Files beside a command, as downloads. @param {{ transfer_name: string, transfer_text: string, more: { name: string, text: string }[] }} command
 * @returns a sentence about them */
export function downloadBeside({ transfer_name: name, transfer_text: text, more }) {
  const files = [{ name, text }, ...more];
  for (const file of files) download(new Blob([file.text], { type: "application/json" }), file.name);
  const names = files.map((file) => file.name).join(", ");
  return files.length > 1 ? `It needs ${names}, which are saved as downloads.` : `It needs ${names}, which is saved as a download.`;
}

/** @param {string} text @returns whether the clipboard took it */
export async function toClipboard(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return false;
  }
}
