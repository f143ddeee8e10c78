// The editor: a text with line numbers, and a mark under the place of an error.

class Editor {
  constructor(onChange) {
    this.text = document.getElementById("text");
    this.marks = document.getElementById("marks");
    this.numbers = document.getElementById("numbers");
    this.trouble = null;
    this.text.addEventListener("input", () => {
      this.mark(null);
      onChange();
    });
    this.text.addEventListener("scroll", () => this.follow());
    this.text.addEventListener("keydown", (event) => this.key(event));
  }

  get value() {
    return this.text.value;
  }

  set value(text) {
    this.text.value = text;
    this.mark(null);
    this.text.scrollTo(0, 0);
  }

  /** Replaces the text as an edit, which the browser can undo. */
  replace(text) {
    const { selectionStart, scrollTop, scrollLeft } = this.text;
    this.text.setRangeText(text, 0, this.text.value.length, "preserve");
    this.text.setSelectionRange(selectionStart, selectionStart);
    this.text.scrollTo(scrollLeft, scrollTop);
    this.mark(null);
  }

  /** Tab indents; Escape, then Tab, leaves the editor. */
  key(event) {
    if (event.key === "Escape") this.leaves = true;
    else if (event.key === "Tab" && !event.shiftKey && !this.leaves && !event.ctrlKey && !event.altKey) {
      event.preventDefault();
      this.text.setRangeText("    ", this.text.selectionStart, this.text.selectionEnd, "end");
      this.text.dispatchEvent(new Event("input"));
    } else if (event.key !== "Shift") this.leaves = false;
  }

  /** Marks the place of a trouble: line and column from 1, and a width, in characters. */
  mark(trouble) {
    this.trouble = trouble?.line ? trouble : null;
    const lines = this.value.split("\n");
    this.numbers.replaceChildren();
    lines.forEach((_, number) => {
      const isWrong = this.trouble?.line === number + 1;
      const label = isWrong ? document.createElement("b") : document.createTextNode(String(number + 1));
      if (isWrong) label.textContent = String(number + 1);
      this.numbers.append(label, "\n");
    });
    this.marks.replaceChildren();
    if (this.trouble) {
      const { start, end } = this.range();
      const mark = document.createElement("mark");
      mark.textContent = this.value.slice(start, end) || " ";
      this.marks.append(this.value.slice(0, start), mark, `${this.value.slice(end)}\n`);
    }
    this.follow();
  }

  /** The marked part of the text. The program counts characters, and the browser units of 16 bits. */
  range() {
    const { line, column, width } = this.trouble;
    const lines = this.value.split("\n");
    const before = lines.slice(0, line - 1).reduce((sum, text) => sum + text.length + 1, 0);
    const characters = Array.from(lines[line - 1] ?? "");
    const units = (count) => characters.slice(0, count).join("").length;
    const start = before + units(column - 1);
    return { start, end: Math.max(before + units(column - 1 + (width ?? 1)), start) };
  }

  /** Puts the cursor at the marked place. */
  go() {
    if (!this.trouble) return;
    const { start, end } = this.range();
    this.text.focus();
    this.text.setSelectionRange(start, end);
    const height = parseFloat(getComputedStyle(this.text).lineHeight);
    this.text.scrollTop = (this.trouble.line - 4) * height;
  }

  follow() {
    this.marks.scrollTop = this.text.scrollTop;
    this.marks.scrollLeft = this.text.scrollLeft;
    this.numbers.parentElement.scrollTop = this.text.scrollTop;
  }
}
